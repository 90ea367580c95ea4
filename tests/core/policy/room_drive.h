#pragma once

#include <vector>

#include "core/frame/frame.h"
#include "tests/support/analytic_scene.h"

/// A robot that looks around in the corner of a room, ten frames a second.
namespace steadymap::testing {

/// Two walls, a floor and four boxes of different shapes, all within 3 m.
Scene Room();

/// The same without its first `count` boxes.
Scene RoomWithout(std::size_t count);

/// Where the camera is in frame `index`: it turns and drives to and fro.
SceneLook LookOf(int index);

/// Frames `first` to `first + count - 1` of the drive, `pause_s` later than without a pause.
std::vector<Frame> Drive(const Scene& scene, int first, int count, double pause_s = 0.0);

/// The same frames from a robot that took itself to be `shift_m` further left and `turn_rad`
/// further round from the first one on.
std::vector<Frame> Mislead(std::vector<Frame> frames, double shift_m, double turn_rad);

/// The same frames from another robot.
std::vector<Frame> From(const std::string& robot, std::vector<Frame> frames);

}  // namespace steadymap::testing
