#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "client/bench/evaluation/truth/surface_points.h"
#include "client/bench/simulator/scene/scene.h"
#include "client/bench/simulator/sensor/sensor_model.h"
#include "core/frame/frame.h"

namespace steadymap {

/// Where things can stand in a recorded room, and be seen.
struct RecordedRoom {
  std::vector<SurfacePoint> surface;  ///< At most `spacing_m` apart; z up.
  double spacing_m = 0.05;
  /// Some frames, evenly spaced, with poses in the frame of the surface. Never empty.
  std::vector<Frame> views;
  double max_depth_m = 4.0;  ///< Farther things are not seen.
  SensorModel sensor;
};

/// A change of one thing between two drives through the same room.
enum class ThingChange { kNone, kMovedNear, kMovedFar, kTurned, kRemoved, kAdded };

/// Returns the name of a change, such as `moved-near`.
std::string_view NameOf(ThingChange change);

/// A thing of a case. Both poses are valid, but for the thing that a change removes or adds.
struct PlacedThing {
  ThingChange change = ThingChange::kNone;
  std::uint16_t id = 0;  ///< In both scenes.
};

/// Two scenes of things in a recorded room.
struct CompositeCase {
  Scene before;
  Scene after;
  std::vector<PlacedThing> things;
};

/// Puts one thing for each change on level surface: each with a shape of its own, where most views
/// show it before and after, apart from the other things. Moves go 10 to 30 cm (near), and 30 cm to
/// 1 m (far); turns 30 to 90 degrees. Leaves out things for which a search finds no place. Equal
/// arguments give equal cases.
CompositeCase MakeCompositeCase(const RecordedRoom& room, std::uint64_t seed);

}  // namespace steadymap
