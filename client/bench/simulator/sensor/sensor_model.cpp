#include "client/bench/simulator/sensor/sensor_model.h"

#include <cmath>

#include "client/bench/simulator/scene/counter_random.h"

namespace steadymap {
namespace {

constexpr std::uint64_t kDriftStream = 6;
constexpr std::uint64_t kOffsetStream = 7;
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

Eigen::Isometry3d DriftPose(const SensorModel& sensor,
                            std::uint64_t seed,
                            double time_s,
                            const Eigen::Isometry3d& T_world_camera) {
  if (!sensor.pose_drift) return T_world_camera;
  const std::uint64_t key = Combine(seed, kDriftStream);
  const Eigen::Vector3d offset_m = sensor.pose_drift_m * WanderAlongAxes(Combine(key, 0), time_s);
  const Eigen::Vector3d turn_rad = sensor.pose_drift_rad * WanderAlongAxes(Combine(key, 1), time_s);
  const Eigen::Matrix3d turn = (Eigen::AngleAxisd(turn_rad.z(), Eigen::Vector3d::UnitZ()) *
                                Eigen::AngleAxisd(turn_rad.y(), Eigen::Vector3d::UnitY()) *
                                Eigen::AngleAxisd(turn_rad.x(), Eigen::Vector3d::UnitX()))
                                   .toRotationMatrix();
  // Rotates about the camera, not the world's origin: far from the origin a rotation would become a
  // large offset.
  Eigen::Isometry3d drifted = T_world_camera;
  drifted.linear() = turn * T_world_camera.linear();
  drifted.translation() += offset_m;
  return drifted;
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
