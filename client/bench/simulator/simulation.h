#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/bench/simulator/scene/route.h"
#include "client/bench/simulator/sensor/renderer.h"
#include "client/bench/simulator/sensor/sensor_model.h"
#include "core/frame/frame.h"

namespace steadymap {

/// A period with a wrong localisation: the reported pose jumps away and later back.
struct LostStretch {
  std::size_t first_frame = 0;
  std::size_t frame_count = 0;  ///< 0: no such period.
  /// Error of the poses meanwhile: a rotation about the true position, and a shift to the robot's
  /// left.
  double shift_m = 1.5;
  double turn_rad = 0.7;
};

/// Options of a simulation.
struct SimulationOptions {
  SensorModel sensor = {};  ///< `SensorModel::Ideal()` for a perfect sensor.
  std::uint64_t seed = 1;   ///< Of all noise.
  std::size_t stride = 1;   ///< Keeps every `stride`-th frame, >= 1.
  LostStretch lost = {};    ///< Frames with wrong poses.
  bool include_color = false;
  std::optional<bool> include_instances = std::nullopt;           ///< Unset: the route's default.
  SensorName source = {"simulator", SensorName::kDefaultSensor};  ///< Of every frame.
  /// Capture time of the first frame.
  Timestamp start_time = Timestamp::FromNanoseconds(1'650'000'000'000'000'000);
};

/// Plays a route: renders any frame, in any order, always with the same bits.
///
/// Frame `i` is independent of earlier calls. Not thread-safe; use one simulation per thread.
class Simulation {
 public:
  Simulation(Route route, SimulationOptions options);
  ~Simulation();
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  const Route& route() const { return route_; }

  const SimulationOptions& options() const { return options_; }

  /// Number of frames of all sequences.
  std::size_t frame_count() const { return frames_.size(); }

  /// Index into `route().sequences` of frame `index`.
  std::size_t SequenceOf(std::size_t index) const { return frames_[index].sequence; }

  /// Returns the capture time of frame `index`.
  Timestamp CaptureTimeOf(std::size_t index) const { return frames_[index].capture_time; }

  /// Returns the true pose of the camera in frame `index`, `T_world_camera`.
  Eigen::Isometry3d TruePose(std::size_t index) const;

  /// Renders frame `index`, in [0, frame_count()), with pose (including drift and error), time and
  /// robot.
  Frame Render(std::size_t index);

 private:
  struct Moment {
    std::size_t sequence = 0;
    double time_s = 0.0;  ///< Since the start of the sequence.
    Timestamp capture_time;
  };

  Route route_;
  SimulationOptions options_;
  std::vector<Moment> frames_;
  std::size_t renderer_sequence_ = 0;
  std::unique_ptr<Renderer> renderer_;  ///< Of `renderer_sequence_`; null before the first frame.
};

}  // namespace steadymap
