#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "client/bench/evaluation/method/method.h"
#include "client/bench/evaluation/method/stage_clock.h"
#include "client/bench/evaluation/truth/surface_points.h"
#include "core/frame/frame.h"
#include "core/map/object_event.h"
#include "core/mapper.h"

namespace steadymap {

/// What a map costs.
struct MapCost {
  std::size_t memory_bytes = 0;  ///< Of the final map's volumes.
  /// Mean of the present objects' volumes; NaN without objects.
  double bytes_per_object = std::numeric_limits<double>::quiet_NaN();
  /// What the deltas tell of packed leaves, states and events, by frame; 0 without frames.
  double delta_bytes_per_frame = 0.0;
  double median_frame_ms = 0.0;  ///< Wall time of a frame without commits; 0 without frames.
  StageTimes stage_ms{};         ///< Mean by frame, commits included; zeros without frames.
};

/// What a method made of a route.
struct MethodOutcome {
  std::shared_ptr<const MapSnapshot> map;
  std::vector<SurfacePoint> surface;  ///< Of the final map.
  std::vector<ObjectEvent> events;    ///< In the order they were decided.
  MapCost cost;
};

/// Builds a map by one method, frame by frame, on the calling thread.
class MethodRun {
 public:
  /// Errors: as `Mapper::Create`.
  static absl::StatusOr<MethodRun> Start(const Method& method);

  /// Takes in a valid frame, unless the method is not to be shown it.
  void Integrate(const Frame& frame, bool is_last_sequence);

  /// Samples the final map's surface every `spacing_m`. Call once.
  MethodOutcome Finish(double spacing_m);

 private:
  MethodRun(const Method& method,
            std::unique_ptr<StageClock> clock,
            std::unique_ptr<Mapper> mapper);

  void Commit();

  bool last_sequence_only_ = false;
  std::unique_ptr<StageClock> clock_;  ///< Watches the mapper.
  std::unique_ptr<Mapper> mapper_;
  std::shared_ptr<const MapSnapshot> snapshot_;
  std::vector<ObjectEvent> events_;
  std::size_t delta_bytes_ = 0;
  std::vector<double> frame_ms_;
};

}  // namespace steadymap
