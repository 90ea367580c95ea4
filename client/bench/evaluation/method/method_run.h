#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "client/bench/evaluation/method/method.h"
#include "client/bench/evaluation/method/stage_clock.h"
#include "client/bench/evaluation/truth/stamped_pose.h"
#include "client/bench/evaluation/truth/surface_points.h"
#include "core/frame/frame.h"
#include "core/map/object_event.h"
#include "core/mapper.h"

namespace steadymap {

/// Cost of a map.
struct MapCost {
  std::size_t memory_bytes = 0;  ///< Of the final map's volumes.
  /// Mean size of the present objects' volumes; NaN without objects.
  double bytes_per_object = std::numeric_limits<double>::quiet_NaN();
  /// Mean size of the delta (packed leaves, states, events) per frame; 0 without frames.
  double delta_bytes_per_frame = 0.0;
  double median_frame_ms = 0.0;  ///< Wall time of a frame without commits; 0 without frames.
  StageTimes stage_ms{};         ///< Mean per frame, with commits; 0 without frames.
};

/// Result of a method on a route.
struct MethodOutcome {
  std::shared_ptr<const MapSnapshot> map;
  std::vector<SurfacePoint> surface;  ///< Of the final map.
  std::vector<ObjectEvent> events;    ///< In the order of the decisions.
  CameraPath registered;              ///< Poses of the frames that were registered to the map.
  MapCost cost;
};

/// Builds a map with one method, frame by frame, on the calling thread.
class MethodRun {
 public:
  /// Errors: those of `Mapper::Create`.
  static absl::StatusOr<MethodRun> Start(const Method& method);

  /// Integrates a valid frame, unless the method skips its sequence.
  void Integrate(const Frame& frame, bool is_last_sequence);

  /// Ends a sequence, as which a method that decides by session takes a session.
  void EndSequence();

  /// Samples the final map's surface every `spacing_m`. Call once.
  MethodOutcome Finish(double spacing_m);

 private:
  MethodRun(const Method& method,
            std::unique_ptr<StageClock> clock,
            std::unique_ptr<Mapper> mapper);

  void NoteRegisteredPose(const Frame& frame);

  void Commit();

  bool last_sequence_only_ = false;
  bool has_sessions_ = false;
  SensorName source_;                  ///< Of the last frame.
  std::unique_ptr<StageClock> clock_;  ///< Observes the mapper.
  std::unique_ptr<Mapper> mapper_;
  std::shared_ptr<const MapSnapshot> snapshot_;
  std::vector<ObjectEvent> events_;
  CameraPath registered_;
  std::size_t delta_bytes_ = 0;
  std::vector<double> frame_ms_;
};

}  // namespace steadymap
