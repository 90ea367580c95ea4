#include "client/bench/simulator/scene/trajectory.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>

#include "client/dataset/layouts/torwic_layout.h"

namespace steadymap {
namespace {

double HeadingOf(const Eigen::Vector2d& direction) {
  return std::atan2(direction.y(), direction.x());
}

// The arc of one corner: its start and end, and its turn.
struct Corner {
  Eigen::Vector2d start_world;
  Eigen::Vector2d end_world;
  double heading_rad = 0.0;
  double turn_rad = 0.0;
  double radius_m = 0.0;
};

Corner RoundCorner(const Eigen::Vector2d& previous,
                   const Eigen::Vector2d& corner,
                   const Eigen::Vector2d& next,
                   double radius_m) {
  const Eigen::Vector2d in = (corner - previous).normalized();
  const Eigen::Vector2d out = (next - corner).normalized();
  const double turn_rad = std::atan2(in.x() * out.y() - in.y() * out.x(), in.dot(out));
  const double tangent = std::tan(std::abs(turn_rad) / 2);
  // Each corner uses at most half of a leg.
  const double shortest_m = std::min((corner - previous).norm(), (next - corner).norm());
  const double cut_m = std::min(radius_m * tangent, shortest_m / 2);
  return {corner - cut_m * in,
          corner + cut_m * out,
          HeadingOf(in),
          turn_rad,
          tangent > 0 ? cut_m / tangent : 0.0};
}

}  // namespace

GroundPath::GroundPath(const std::vector<Eigen::Vector2d>& corners_world,
                       double corner_radius_m,
                       bool is_closed)
    : is_closed_(is_closed) {
  const std::size_t count = corners_world.size();
  assert(count >= (is_closed ? 3U : 2U));
  const Eigen::Vector2d start =
      is_closed ? Eigen::Vector2d((corners_world.back() + corners_world.front()) / 2)
                : corners_world.front();
  const Eigen::Vector2d end = is_closed ? start : corners_world.back();
  Eigen::Vector2d position = start;
  for (std::size_t i = is_closed ? 0 : 1; i < (is_closed ? count : count - 1); ++i) {
    const Corner corner = RoundCorner(corners_world[(i + count - 1) % count],
                                      corners_world[i],
                                      corners_world[(i + 1) % count],
                                      corner_radius_m);
    AppendLine(position, corner.start_world);
    if (corner.radius_m > 0) {
      const double arc_m = std::abs(corner.turn_rad) * corner.radius_m;
      pieces_.push_back({corner.start_world,
                         corner.heading_rad,
                         arc_m,
                         std::copysign(1 / corner.radius_m, corner.turn_rad)});
      length_m_ += arc_m;
    }
    position = corner.end_world;
  }
  AppendLine(position, end);
  assert(!pieces_.empty());
}

void GroundPath::AppendLine(const Eigen::Vector2d& from_world, const Eigen::Vector2d& to_world) {
  const double piece_m = (to_world - from_world).norm();
  if (piece_m < 1e-9) return;
  pieces_.push_back({from_world, HeadingOf(to_world - from_world), piece_m, 0.0});
  length_m_ += piece_m;
}

Eigen::Isometry3d GroundPath::PoseAt(double distance_m) const {
  double rest_m = std::clamp(distance_m, 0.0, length_m_);
  if (is_closed_) rest_m = distance_m - length_m_ * std::floor(distance_m / length_m_);
  auto piece = pieces_.begin();
  while (piece + 1 != pieces_.end() && rest_m > piece->length_m) rest_m -= (piece++)->length_m;
  const double curvature = piece->curvature_per_m;
  const double heading_rad = piece->start_heading_rad + curvature * rest_m;
  Eigen::Vector2d position = piece->start_world;
  if (curvature == 0.0) {
    position += rest_m * Eigen::Vector2d(std::cos(heading_rad), std::sin(heading_rad));
  } else {
    position.x() += (std::sin(heading_rad) - std::sin(piece->start_heading_rad)) / curvature;
    position.y() -= (std::cos(heading_rad) - std::cos(piece->start_heading_rad)) / curvature;
  }
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = Eigen::Vector3d(position.x(), position.y(), 0.0);
  pose.linear() = Eigen::AngleAxisd(heading_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return pose;
}

Trajectory DriveAlong(const GroundPath& path, double speed_m_per_s, double base_height_m) {
  Trajectory trajectory;
  trajectory.duration_s = path.length_m() / speed_m_per_s;
  trajectory.T_world_camera = [path, speed_m_per_s, base_height_m](double time_s) {
    Eigen::Isometry3d T_world_base = path.PoseAt(speed_m_per_s * time_s);
    T_world_base.translation().z() = base_height_m;
    return Eigen::Isometry3d(T_world_base * DefaultTorwicCalibration().T_base_camera);
  };
  return trajectory;
}

Eigen::Isometry3d LookAt(const Eigen::Vector3d& eye_world, const Eigen::Vector3d& target_world) {
  const Eigen::Vector3d z = (target_world - eye_world).normalized();
  const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() << x, z.cross(x), z;
  pose.translation() = eye_world;
  return pose;
}

}  // namespace steadymap
