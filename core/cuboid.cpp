#include "core/cuboid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace steadymap {
namespace {

Eigen::Matrix2d PlanRotation(double yaw_rad) {
  return Eigen::Rotation2Dd(yaw_rad).toRotationMatrix();
}

/// A point seen from above in the frame of the box.
Eigen::Vector2d PlanInCuboid(const Cuboid& cuboid, const Eigen::Vector2d& point_world) {
  return PlanRotation(cuboid.yaw_rad).transpose() * (point_world - cuboid.center_world.head<2>());
}

double PlanDistance(const Cuboid& cuboid, const Eigen::Vector2d& point_world) {
  const Eigen::Vector2d beyond_m =
      PlanInCuboid(cuboid, point_world).cwiseAbs() - 0.5 * cuboid.size_m.head<2>();
  return beyond_m.cwiseMax(0.0).norm();
}

/// Whether a line along a side of `a` keeps the two bases apart.
bool SideSeparates(const Cuboid& a, const Cuboid& b) {
  Eigen::Vector2d low_m = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d high_m = -low_m;
  for (const Eigen::Vector2d& corner_world : b.BaseCorners()) {
    const Eigen::Vector2d corner_m = PlanInCuboid(a, corner_world);
    low_m = low_m.cwiseMin(corner_m);
    high_m = high_m.cwiseMax(corner_m);
  }
  const Eigen::Vector2d half_m = 0.5 * a.size_m.head<2>();
  return (low_m.array() > half_m.array()).any() || (high_m.array() < -half_m.array()).any();
}

double PlanDistance(const Cuboid& a, const Cuboid& b) {
  if (!SideSeparates(a, b) && !SideSeparates(b, a)) return 0.0;
  // Of two convex polygons that are apart, one has a corner nearest to the other.
  double least_m = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector2d& corner_world : a.BaseCorners()) {
    least_m = std::min(least_m, PlanDistance(b, corner_world));
  }
  for (const Eigen::Vector2d& corner_world : b.BaseCorners()) {
    least_m = std::min(least_m, PlanDistance(a, corner_world));
  }
  return least_m;
}

using Polygon = std::vector<Eigen::Vector2d>;

/// The part of a convex polygon where `normal.dot(point) <= limit_m` (Sutherland and Hodgman,
/// 1974).
Polygon ClipToHalfPlane(const Polygon& polygon, const Eigen::Vector2d& normal, double limit_m) {
  Polygon clipped;
  clipped.reserve(polygon.size() + 1);
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& from = polygon[i];
    const Eigen::Vector2d& to = polygon[(i + 1) % polygon.size()];
    const double from_beyond_m = normal.dot(from) - limit_m;
    const double to_beyond_m = normal.dot(to) - limit_m;
    if (from_beyond_m <= 0.0) clipped.push_back(from);
    if ((from_beyond_m <= 0.0) != (to_beyond_m <= 0.0)) {
      clipped.emplace_back(from + from_beyond_m / (from_beyond_m - to_beyond_m) * (to - from));
    }
  }
  return clipped;
}

/// Half the sum of the cross products of neighbouring corners.
double Area(const Polygon& polygon) {
  double twice_m2 = 0.0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& from = polygon[i];
    const Eigen::Vector2d& to = polygon[(i + 1) % polygon.size()];
    twice_m2 += from.x() * to.y() - to.x() * from.y();
  }
  return std::max(0.0, 0.5 * twice_m2);
}

double PlanOverlapM2(const Cuboid& a, const Cuboid& b) {
  Polygon shared;
  for (const Eigen::Vector2d& corner_world : a.BaseCorners()) {
    shared.push_back(PlanInCuboid(b, corner_world));
  }
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector2d normal = Eigen::Vector2d::Unit(axis);
    shared = ClipToHalfPlane(shared, normal, 0.5 * b.size_m[axis]);
    shared = ClipToHalfPlane(shared, -normal, 0.5 * b.size_m[axis]);
  }
  return Area(shared);
}

/// Heading of the major axis of the points seen from above, radians in (-pi/2, pi/2].
double MajorAxisYaw(std::span<const Eigen::Vector3d> points_world) {
  if (points_world.empty()) return 0.0;
  Eigen::Vector2d mean_world = Eigen::Vector2d::Zero();
  for (const Eigen::Vector3d& point_world : points_world) mean_world += point_world.head<2>();
  mean_world /= static_cast<double>(points_world.size());
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector3d& point_world : points_world) {
    const Eigen::Vector2d offset_m = point_world.head<2>() - mean_world;
    scatter += offset_m * offset_m.transpose();
  }
  const double yaw_rad = 0.5 * std::atan2(2.0 * scatter(0, 1), scatter(0, 0) - scatter(1, 1));
  // atan2 tells -0 from 0, a heading does not.
  return yaw_rad > -0.5 * std::numbers::pi ? yaw_rad : 0.5 * std::numbers::pi;
}

}  // namespace

Eigen::Isometry3d Cuboid::T_world_cuboid() const {
  Eigen::Isometry3d T_world_cuboid = Eigen::Isometry3d::Identity();
  T_world_cuboid.translation() = center_world;
  T_world_cuboid.linear().topLeftCorner<2, 2>() = PlanRotation(yaw_rad);
  return T_world_cuboid;
}

std::array<Eigen::Vector2d, 4> Cuboid::BaseCorners() const {
  const Eigen::Matrix2d R_world_cuboid = PlanRotation(yaw_rad);
  const Eigen::Vector2d along_m = R_world_cuboid.col(0) * (0.5 * size_m.x());
  const Eigen::Vector2d across_m = R_world_cuboid.col(1) * (0.5 * size_m.y());
  const Eigen::Vector2d center = center_world.head<2>();
  return {center - along_m - across_m,
          center + along_m - across_m,
          center + along_m + across_m,
          center - along_m + across_m};
}

double DistanceTo(const Cuboid& cuboid, const Eigen::Vector3d& point_world) {
  const double above_m = point_world.z() - cuboid.highest_m();
  const double below_m = cuboid.lowest_m() - point_world.z();
  return std::hypot(PlanDistance(cuboid, point_world.head<2>()), std::max({0.0, above_m, below_m}));
}

double DistanceBetween(const Cuboid& a, const Cuboid& b) {
  const double above_m = a.lowest_m() - b.highest_m();
  const double below_m = b.lowest_m() - a.highest_m();
  return std::hypot(PlanDistance(a, b), std::max({0.0, above_m, below_m}));
}

double OverlapM3(const Cuboid& a, const Cuboid& b) {
  const double shared_height_m =
      std::min(a.highest_m(), b.highest_m()) - std::max(a.lowest_m(), b.lowest_m());
  if (shared_height_m <= 0.0) return 0.0;
  return shared_height_m * PlanOverlapM2(a, b);
}

Cuboid FitCuboid(std::span<const Eigen::Vector3d> points_world) {
  return FitCuboid(points_world, MajorAxisYaw(points_world));
}

Cuboid FitCuboid(std::span<const Eigen::Vector3d> points_world, double yaw_rad) {
  Cuboid cuboid;
  cuboid.yaw_rad = yaw_rad;
  if (points_world.empty()) return cuboid;
  // Offsets from a point of the set, not from the origin: far from it digits would be lost.
  const Eigen::Vector3d& reference_world = points_world.front();
  Eigen::Matrix3d R_world_cuboid = Eigen::Matrix3d::Identity();
  R_world_cuboid.topLeftCorner<2, 2>() = PlanRotation(yaw_rad);
  Eigen::Vector3d low_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d high_m = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point_world : points_world) {
    const Eigen::Vector3d offset_m = R_world_cuboid.transpose() * (point_world - reference_world);
    low_m = low_m.cwiseMin(offset_m);
    high_m = high_m.cwiseMax(offset_m);
  }
  cuboid.center_world = reference_world + R_world_cuboid * (0.5 * (low_m + high_m));
  cuboid.size_m = high_m - low_m;
  return cuboid;
}

}  // namespace steadymap
