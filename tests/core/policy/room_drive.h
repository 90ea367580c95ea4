#pragma once

#include <vector>

#include "core/frame/frame.h"
#include "tests/support/analytic_scene.h"

/// A robot that drives and turns in the corner of a room, at ten frames a second.
namespace steadymap::testing {

/// Returns two walls, a floor and four boxes of different shapes, all within 3 m.
Scene Room();

/// Returns the room without its first `count` boxes.
Scene RoomWithout(std::size_t count);

/// Returns the camera pose of frame `index`. The camera turns and drives back and forth.
SceneLook LookOf(int index);

/// Returns frames `first` to `first + count - 1` of the drive, delayed by `pause_s`.
std::vector<Frame> Drive(const Scene& scene, int first, int count, double pause_s = 0.0);

/// Returns the frames with the poses of a robot with a localization error: all poses are shifted
/// `shift_m` to the left and rotated by `turn_rad` about the first position.
std::vector<Frame> Mislead(std::vector<Frame> frames, double shift_m, double turn_rad);

/// Returns the same frames from another robot.
std::vector<Frame> From(const std::string& robot, std::vector<Frame> frames);

}  // namespace steadymap::testing
