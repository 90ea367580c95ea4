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

/// Maps under observation: scenes with a known answer, run through a policy frame by frame.
namespace steadymap::testing {

/// A wall that closes the view at 2.6 m.
SceneBody FarWall();

/// A box half a metre wide in front of it, its middle at `y` and its front at `x`.
SceneBody Goods(double y, double x = 1.6);

/// Around a body, `margin_m` further on all sides.
Box Around(const SceneBody& body, double margin_m);

/// A map's configuration with nothing but the policy set.
MapConfig ConfigOf(UpdatePolicy policy);

/// The one of the policy that this map is made for.
MapConfig PocdConfig();

/// Frames of a scene from a camera that swings to and fro, going on from frame `first`; half a
/// second apart, and another minute before each visit but the first.
std::vector<Frame> LookAtScene(const Scene& scene, int first, int count, int visit = 0);

/// A frame of goods that fill the view of a small camera.
Frame SmallFrame(int width_px, int height_px, double depth_m, double capture_time_s);

/// A map from its first frame on.
class MapStory {
 public:
  explicit MapStory(const MapConfig& config, const MapperOptions& options = {});

  /// Takes in frames, with a commit after every `frames_per_commit` and at the end.
  void Play(const std::vector<Frame>& frames, std::size_t frames_per_commit = 1);

  /// Goes on looking at a scene. Another `visit` comes after a pause.
  void Look(const Scene& scene, int count, int visit = 0);

  /// Goes on as after a restart: from what the deltas told, applied to an empty map.
  void Restart();

  const std::vector<ObjectEvent>& events() const { return events_; }

  /// Events of a type about things of a class, from revision `after` + 1 on.
  std::vector<ObjectEvent> EventsOf(EventType type,
                                    std::uint16_t label,
                                    Revision after = Revision(0)) const;

  const MapSnapshot& map() const { return *map_; }

  /// The map as the deltas told it.
  const MapSnapshot& told() const { return told_; }

  /// Present objects of a class.
  std::vector<std::shared_ptr<const MapObject>> Present(std::uint16_t label) const;

 private:
  void Commit();

  /// Follows the present objects by the events alone.
  void Replay(const ObjectEvent& event);

  MapConfig config_;
  MapperOptions options_;
  std::unique_ptr<Mapper> mapper_;
  std::shared_ptr<const MapSnapshot> map_;
  MapSnapshot told_;
  std::vector<ObjectEvent> events_;
  std::set<ObjectId> present_by_events_;
};

/// All leaves of a map, as they are stored.
std::map<LeafKey, std::string> PackedLeaves(const MapSnapshot& map);

/// Expects two maps to hold the same, bit for bit.
void ExpectSameMap(const MapSnapshot& a, const MapSnapshot& b);

/// Vertices of the surface of background and present objects within a box, world frame.
std::size_t CountSurfaceIn(const MapSnapshot& map, const Box& box_world);

}  // namespace steadymap::testing
