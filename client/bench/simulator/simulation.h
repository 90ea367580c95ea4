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

/// A robot whose localisation jumps away, and back after a while.
struct LostStretch {
  std::size_t first_frame = 0;
  std::size_t frame_count = 0;  ///< 0: it never gets lost.
  /// What the poses are off by meanwhile: turned about where it was lost, and shifted to its left.
  double shift_m = 1.5;
  double turn_rad = 0.7;
};

/// How a route is played.
struct SimulationOptions {
  SensorModel sensor = {};  ///< `SensorModel::Ideal()` for a perfect sensor.
  std::uint64_t seed = 1;   ///< Of all noise.
  std::size_t stride = 1;   ///< Every how many frames one is kept, >= 1.
  LostStretch lost = {};    ///< Frames whose poses are wrong.
  bool include_color = false;
  std::optional<bool> include_instances = std::nullopt;           ///< Unset: as the route says.
  SensorName source = {"simulator", SensorName::kDefaultSensor};  ///< Of every frame.
  /// Capture time of the first frame. Later sequences start a minute after the end of the one
  /// before.
  Timestamp start_time = Timestamp::FromNanoseconds(1'650'000'000'000'000'000);
};

/// Plays a route: renders any of its frames, in any order, always with the same bits.
///
/// Frame `i` of the simulation is the same whatever was rendered before. One thread at a time; give
/// each thread a simulation of its own.
class Simulation {
 public:
  Simulation(Route route, SimulationOptions options);
  ~Simulation();
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  const Route& route() const { return route_; }

  const SimulationOptions& options() const { return options_; }

  /// Frames of all sequences together.
  std::size_t frame_count() const { return frames_.size(); }

  /// Index into `route().sequences` of frame `index`.
  std::size_t SequenceOf(std::size_t index) const { return frames_[index].sequence; }

  /// The true pose of the camera in frame `index`, `T_world_camera`.
  Eigen::Isometry3d TruePose(std::size_t index) const;

  /// Frame `index`, in [0, frame_count()), complete with pose (drift and error included), time and
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
