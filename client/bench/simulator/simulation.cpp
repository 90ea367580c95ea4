#include "client/bench/simulator/simulation.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "client/bench/simulator/scene/counter_random.h"

namespace steadymap {
namespace {

constexpr std::uint64_t kSlowStream = 8;

/// Returns the transform from the true pose to the reported pose of a robot that was lost at
/// `T_world_camera`.
Eigen::Isometry3d MisleadingStep(const LostStretch& lost, const Eigen::Isometry3d& T_world_camera) {
  const Eigen::Translation3d here(T_world_camera.translation());
  const Eigen::Vector3d left = -T_world_camera.linear().col(0);
  return Eigen::Translation3d(lost.shift_m * left) * here *
         Eigen::AngleAxisd(lost.turn_rad, Eigen::Vector3d::UnitZ()) * here.inverse();
}

std::int64_t Nanoseconds(double seconds) { return std::llround(seconds * 1e9); }

}  // namespace

Simulation::Simulation(Route route, SimulationOptions options)
    : route_(std::move(route)), options_(std::move(options)) {
  assert(options_.stride >= 1);
  std::int64_t start_ns = options_.start_time.nanoseconds();
  for (std::size_t sequence = 0; sequence < route_.sequences.size(); ++sequence) {
    const Trajectory& trajectory = route_.sequences[sequence].trajectory;
    if (sequence > 0) start_ns += Nanoseconds(route_.sequences[sequence].pause_s);
    const auto count =
        static_cast<std::size_t>(trajectory.duration_s / trajectory.frame_period_s) + 1;
    for (std::size_t i = 0; i < count; i += options_.stride) {
      const double time_s = static_cast<double>(i) * trajectory.frame_period_s;
      const double stop_s = 2.0 * time_s < trajectory.duration_s ? 0.0 : trajectory.stop_s;
      frames_.push_back(
          {sequence, time_s, Timestamp::FromNanoseconds(start_ns + Nanoseconds(time_s + stop_s))});
    }
    start_ns += Nanoseconds(trajectory.duration_s + trajectory.stop_s);
  }
}

Simulation::~Simulation() = default;

Eigen::Isometry3d Simulation::TruePose(std::size_t index) const {
  const Moment& moment = frames_[index];
  return route_.sequences[moment.sequence].trajectory.T_world_camera(moment.time_s);
}

Frame Simulation::Render(std::size_t index) {
  assert(index < frames_.size());
  const Moment& moment = frames_[index];
  if (renderer_ == nullptr || renderer_sequence_ != moment.sequence) {
    const Scene& scene = route_.sequences[moment.sequence].scene;
    renderer_ = std::make_unique<Renderer>(&scene, route_.camera, options_.sensor);
    renderer_sequence_ = moment.sequence;
  }
  // Keyed by the time, not by the index, so that a frame is identical at any stride.
  const std::int64_t elapsed_ns = (moment.capture_time - options_.start_time).nanoseconds();
  View view;
  view.T_world_camera = TruePose(index);
  view.time_s = moment.time_s;
  view.noise_key = Combine(options_.seed, static_cast<std::uint64_t>(elapsed_ns));
  view.slow_noise_key = Combine(Combine(options_.seed, kSlowStream), moment.sequence);
  Frame frame = renderer_->Render(
      view, {options_.include_instances.value_or(route_.has_instances), options_.include_color});
  frame.source = options_.source;
  frame.capture_time = moment.capture_time;
  const Eigen::Isometry3d drifted = DriftPose(
      options_.sensor, options_.seed, static_cast<double>(elapsed_ns) * 1e-9, view.T_world_camera);
  frame.T_world_camera =
      OffsetPose(options_.sensor,
                 options_.seed,
                 moment.sequence,
                 WalkPose(options_.sensor, options_.seed, moment.sequence, moment.time_s, drifted));
  const LostStretch& lost = options_.lost;
  if (index >= lost.first_frame && index - lost.first_frame < lost.frame_count) {
    frame.T_world_camera = MisleadingStep(lost, TruePose(lost.first_frame)) * frame.T_world_camera;
  }
  return frame;
}

}  // namespace steadymap
