#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/mapper.h"
#include "tests/support/analytic_scene.h"

/// Maps of scenes with known ground truth, updated by a policy frame by frame.
namespace steadymap::testing {

/// Returns a wall that closes the view at 2.6 m.
SceneBody FarWall();

/// Returns a box 0.5 m wide in front of the wall, with its centre at `y` and its front at `x`.
SceneBody Goods(double y, double x = 1.6);

/// Returns the box of a body, enlarged by `margin_m` on all sides.
Box Around(const SceneBody& body, double margin_m);

/// Returns the default configuration of a map with the given policy.
MapConfig ConfigOf(UpdatePolicy policy);

/// Returns the default configuration of a map with the pocd policy.
MapConfig PocdConfig();

/// Returns the same with voxels of 2 cm.
MapConfig FinePocdConfig();

/// Returns frames of a scene from a camera that moves back and forth, beginning with frame `first`.
/// Frames are 0.5 s apart, with an additional minute before each visit except the first.
std::vector<Frame> LookAtScene(const Scene& scene, int first, int count, int visit = 0);

/// Returns a frame in which goods fill the view of a small camera.
Frame SmallFrame(int width_px, int height_px, double depth_m, double capture_time_s);

/// A map, recorded from its first frame on.
class MapStory {
 public:
  explicit MapStory(const MapConfig& config, StageObserver* stages = nullptr);

  /// Integrates frames, with a commit after every `frames_per_commit` frames and at the end.
  void Play(const std::vector<Frame>& frames, std::size_t frames_per_commit = 1);

  /// Integrates the next `count` frames of a scene. A new `visit` begins after a pause.
  void Look(const Scene& scene, int count, int visit = 0);

  /// Ends the session of the last frame, or that of a sensor, with a commit.
  void EndSession();
  void EndSession(const SensorName& sensor);

  /// Restarts the mapper from the map rebuilt from the deltas.
  void Restart();

  const std::vector<ObjectEvent>& events() const { return events_; }

  /// Returns the events of a type for objects of a class, from revision `after` + 1 on.
  std::vector<ObjectEvent> EventsOf(EventType type,
                                    std::uint16_t label,
                                    Revision after = Revision(0)) const;

  const MapSnapshot& map() const { return *map_; }

  /// Returns the map rebuilt from the deltas alone.
  const MapSnapshot& told() const { return told_; }

  /// Returns the present objects of a class.
  std::vector<std::shared_ptr<const MapObject>> Present(std::uint16_t label) const;

 private:
  void Commit();

  /// Updates the set of present objects from one event.
  void Replay(const ObjectEvent& event);

  MapConfig config_;
  StageObserver* stages_;
  std::unique_ptr<Mapper> mapper_;
  std::shared_ptr<const MapSnapshot> map_;
  MapSnapshot told_;
  std::vector<ObjectEvent> events_;
  std::set<ObjectId> present_by_events_;
  SensorName last_source_;
};

/// Returns all leaves of a map in their stored encoding.
std::map<LeafKey, std::string> PackedLeaves(const MapSnapshot& map);

/// Expects two maps to be bit-identical.
void ExpectSameMap(const MapSnapshot& a, const MapSnapshot& b);

/// Returns the number of surface vertices of background and present objects within a box in the
/// world frame.
std::size_t CountSurfaceIn(const MapSnapshot& map, const Box& box_world);

}  // namespace steadymap::testing
