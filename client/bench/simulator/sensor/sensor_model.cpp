#include "client/bench/simulator/sensor/sensor_model.h"

#include <algorithm>
#include <cmath>

#include "client/bench/simulator/scene/counter_random.h"

namespace steadymap {
namespace {

constexpr std::uint64_t kDriftStream = 6;
constexpr std::uint64_t kOffsetStream = 7;
constexpr std::uint64_t kWalkStream = 9;
constexpr double kShortestPeriodS = 20.0;
constexpr double kLongestPeriodS = 70.0;

// Returns a drift within [-1, 1]: two slow waves of random period and phase.
double Wander(std::uint64_t key, double time_s) {
  double sum = 0.0;
  for (std::uint64_t wave = 0; wave < 2; ++wave) {
    const double period_s = UniformBetween(key, 2 * wave, kShortestPeriodS, kLongestPeriodS);
    const double phase_rad = UniformBetween(key, 2 * wave + 1, 0, 2 * M_PI);
    sum += 0.5 * std::sin(2 * M_PI * time_s / period_s + phase_rad);
  }
  return sum;
}

Eigen::Vector3d WanderAlongAxes(std::uint64_t key, double time_s) {
  return {Wander(Combine(key, 0), time_s),
          Wander(Combine(key, 1), time_s),
          Wander(Combine(key, 2), time_s)};
}

/// Returns a random walk at a time: uniform steps of variance one each second, with straight lines
/// between them.
double Walk(std::uint64_t key, double time_s) {
  const double kReach = std::sqrt(3.0);  // Of a uniform step of variance one.
  const auto whole = static_cast<std::uint64_t>(std::max(time_s, 0.0));
  double sum = 0.0;
  for (std::uint64_t step = 0; step < whole; ++step) {
    sum += UniformBetween(key, step, -kReach, kReach);
  }
  return sum + (time_s - static_cast<double>(whole)) * UniformBetween(key, whole, -kReach, kReach);
}

/// Moves a camera, and turns it about itself, not about the world's origin: far from the origin a
/// rotation would become a large offset.
Eigen::Isometry3d Displace(const Eigen::Vector3d& offset_m,
                           const Eigen::Vector3d& turn_rad,
                           const Eigen::Isometry3d& T_world_camera) {
  const Eigen::Matrix3d turn = (Eigen::AngleAxisd(turn_rad.z(), Eigen::Vector3d::UnitZ()) *
                                Eigen::AngleAxisd(turn_rad.y(), Eigen::Vector3d::UnitY()) *
                                Eigen::AngleAxisd(turn_rad.x(), Eigen::Vector3d::UnitX()))
                                   .toRotationMatrix();
  Eigen::Isometry3d displaced = T_world_camera;
  displaced.linear() = turn * T_world_camera.linear();
  displaced.translation() += offset_m;
  return displaced;
}

}  // namespace

SensorModel SensorModel::Ideal() {
  SensorModel sensor;
  sensor.depth_noise = false;
  sensor.disparity_steps = false;
  sensor.flying_pixels = false;
  sensor.grazing_dropout = false;
  sensor.holes = false;
  sensor.label_boundary_noise = false;
  sensor.label_blobs = false;
  sensor.label_flips = false;
  sensor.pose_drift = false;
  return sensor;
}

SensorModel SensorModel::Full() {
  SensorModel sensor;
  sensor.pose_drift = true;
  return sensor;
}

SensorModel SensorModel::Hard() {
  SensorModel sensor = Full();
  sensor.correlated_noise = true;
  sensor.foreground_fattening = true;
  sensor.label_blobs_a_frame = 4.0;
  sensor.label_flip_share = 0.07;
  sensor.unlabelled_share = 0.3;
  sensor.pose_walk_m = 0.004;
  sensor.pose_walk_rad = 0.0005;
  sensor.session_offset_m = 0.05;
  sensor.session_offset_rad = 0.0087;
  return sensor;
}

Eigen::Isometry3d WalkPose(const SensorModel& sensor,
                           std::uint64_t seed,
                           std::size_t session,
                           double time_s,
                           const Eigen::Isometry3d& T_world_camera) {
  if (sensor.pose_walk_m <= 0.0 && sensor.pose_walk_rad <= 0.0) return T_world_camera;
  const std::uint64_t key = Combine(Combine(seed, kWalkStream), session);
  const auto walk = [key, time_s](std::uint64_t axis) { return Walk(Combine(key, axis), time_s); };
  return Displace(sensor.pose_walk_m * Eigen::Vector3d(walk(0), walk(1), walk(2)),
                  {0.0, 0.0, sensor.pose_walk_rad * walk(3)},
                  T_world_camera);
}

Eigen::Isometry3d DriftPose(const SensorModel& sensor,
                            std::uint64_t seed,
                            double time_s,
                            const Eigen::Isometry3d& T_world_camera) {
  if (!sensor.pose_drift) return T_world_camera;
  const std::uint64_t key = Combine(seed, kDriftStream);
  const Eigen::Vector3d offset_m = sensor.pose_drift_m * WanderAlongAxes(Combine(key, 0), time_s);
  const Eigen::Vector3d turn_rad = sensor.pose_drift_rad * WanderAlongAxes(Combine(key, 1), time_s);
  return Displace(offset_m, turn_rad, T_world_camera);
}

Eigen::Isometry3d OffsetPose(const SensorModel& sensor,
                             std::uint64_t seed,
                             std::size_t session,
                             const Eigen::Isometry3d& T_world_camera) {
  if (session == 0) return T_world_camera;
  const std::uint64_t key = Combine(Combine(seed, kOffsetStream), session);
  const double azimuth_rad = UniformBetween(key, 0, 0.0, 2 * M_PI);
  const double height = UniformBetween(key, 1, -1.0, 1.0);  // Uniform on the sphere.
  const double width = std::sqrt(1.0 - height * height);
  const Eigen::Vector3d direction(
      width * std::cos(azimuth_rad), width * std::sin(azimuth_rad), height);
  const double side = UniformBetween(key, 2, 0.0, 1.0) < 0.5 ? -1.0 : 1.0;
  return Eigen::Translation3d(sensor.session_offset_m * direction) *
         Eigen::AngleAxisd(side * sensor.session_offset_rad, Eigen::Vector3d::UnitZ()) *
         T_world_camera;
}

}  // namespace steadymap
