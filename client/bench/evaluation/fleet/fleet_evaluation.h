#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "client/bench/evaluation/fleet/fleet_case.h"
#include "client/bench/evaluation/score/event_score.h"
#include "client/bench/evaluation/score/map_score.h"
#include "client/bench/simulator/sensor/sensor_model.h"
#include "core/map/object_event.h"
#include "core/types/map_config.h"

namespace steadymap {

/// Options of an evaluation of a fleet.
struct FleetEvaluationOptions {
  std::vector<FleetCase> cases;
  MapConfig config;
  SensorModel sensor;
  std::uint64_t seed = 1;  ///< Of all noise.
  double voxel_size_m = 0.2;
  std::function<void()> on_case;  ///< Called after each case; may be empty.
};

/// The result of one case.
struct FleetResult {
  FleetCase fleet_case;
  std::size_t frame_count = 0;
  MapScore map;
  EventScore events;
  std::map<EventType, std::size_t> event_counts;
  std::size_t archived_count = 0;  ///< Objects that the map keeps without their showing in it.
};

/// Plays each case of a route into a map of its own and scores it by the world of the last
/// sequence. Errors: those of `Mapper::Create`.
absl::StatusOr<std::vector<FleetResult>> EvaluateFleet(const Route& route,
                                                       const FleetEvaluationOptions& options);

/// Returns a table with a row for each case.
std::string FleetTable(const std::vector<FleetResult>& results);

}  // namespace steadymap
