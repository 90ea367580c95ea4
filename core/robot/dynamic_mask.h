#pragma once

#include <string>
#include <vector>

#include "core/integration/semantic_cloud.h"
#include "core/map/robot_state.h"
#include "core/types/map_config.h"
#include "core/working/working_map.h"

namespace steadymap {

/// How things that move are remembered. Default: measured on the table-top and the people route.
struct DynamicMaskParameters {
  /// False: each frame knows its own labels alone.
  bool is_on = true;
  /// For how long, seconds. Also the longest time between two frames that confirm each other.
  double memory_s = 1.0;

  friend bool operator==(const DynamicMaskParameters&, const DynamicMaskParameters&) = default;
};

/// Keeps things that move out of the map in the frames that take them for something else: a
/// classifier that has named a car for seconds may call it a crate in between, and what is fused
/// then stays behind as its trail.
///
/// Surface of a dynamic class that a robot sees in two frames within the memory is where something
/// moves. What the robot sees there a moment later weighs nothing, whatever it is called. A patch
/// with a wrong label in one frame hides nothing.
class DynamicMask {
 public:
  DynamicMask(const MapConfig& config, const DynamicMaskParameters& parameters);

  /// Takes its weight from what lies where `sensor` saw something move.
  /// Cost: nothing where nothing moved; with `Record` 0.25 ms a frame on the people route.
  void Apply(const SensorName& sensor, const WorkingMap& map, SemanticCloud* cloud) const;

  /// Notes where `sensor` sees something move, in the map.
  void Record(const SensorName& sensor, const SemanticCloud& cloud, WorkingMap* map) const;

 private:
  bool IsFresh(const MovingCell& cell, const WorkingMap& map) const;
  std::vector<CellIndex> CellsInSight(const SemanticCloud& cloud) const;

  DynamicMaskParameters parameters_;
  double cell_size_m_;
};

}  // namespace steadymap
