#include "core/objects/shape_match.h"

#include <cmath>
#include <utility>
#include <vector>

#include "core/registration/registration.h"

namespace steadymap {
namespace {

// Cuboids whose sides differ by less than the search distance of the registration need one start.
constexpr double kMinSideDifferenceM = 0.1;

/// Returns the shifts along one axis that give two cuboids a side in common, or their middles.
std::vector<double> ShiftsOf(double old_side_m, double new_side_m) {
  const double half_m = 0.5 * (new_side_m - old_side_m);
  if (2.0 * std::abs(half_m) < kMinSideDifferenceM) return {0.0};
  return {0.0, half_m, -half_m};
}

/// Returns the shifts along all axes that give two boxes of these sizes sides or middles in common.
std::vector<Eigen::Translation3d> ShiftsBetween(const Eigen::Vector3d& old_size_m,
                                                const Eigen::Vector3d& new_size_m) {
  std::vector<Eigen::Translation3d> shifts;
  for (const double x_m : ShiftsOf(old_size_m.x(), new_size_m.x())) {
    for (const double y_m : ShiftsOf(old_size_m.y(), new_size_m.y())) {
      for (const double z_m : ShiftsOf(old_size_m.z(), new_size_m.z())) {
        shifts.emplace_back(x_m, y_m, z_m);
      }
    }
  }
  return shifts;
}

/// Returns the poses of a cuboid that give it sides or middles in common with another one, turned
/// by each quarter turn.
std::vector<Eigen::Isometry3d> FindStarts(const Cuboid& old_cuboid, const Cuboid& new_cuboid) {
  std::vector<Eigen::Isometry3d> starts;
  for (int quarter = 0; quarter < 4; ++quarter) {
    const Eigen::AngleAxisd turn(0.5 * M_PI * quarter, Eigen::Vector3d::UnitZ());
    Eigen::Vector3d size_m = old_cuboid.size_m;
    if (quarter % 2 == 1) std::swap(size_m.x(), size_m.y());
    for (const Eigen::Translation3d& shift : ShiftsBetween(size_m, new_cuboid.size_m)) {
      starts.emplace_back(new_cuboid.T_world_cuboid() * shift * turn);
    }
  }
  return starts;
}

}  // namespace

UprightPose UprightPoseOf(const Eigen::Isometry3d& T_world_object) {
  const Eigen::Matrix3d R_world_object = T_world_object.linear();
  return {T_world_object.translation(), std::atan2(R_world_object(1, 0), R_world_object(0, 0))};
}

ShapeMatch MatchShapes(const TrackedObject& before,
                       const TrackedObject& after,
                       const VoxelScale& scale) {
  const std::vector<Eigen::Vector3d> points_world = after.SurfaceInWorld();
  const Eigen::Isometry3d T_world_after = after.state().T_world_object.ToIsometry();
  const Eigen::Isometry3d T_cuboid_object =
      before.cuboid().T_world_cuboid().inverse() * before.state().T_world_object.ToIsometry();
  ShapeMatch best;
  for (const Eigen::Isometry3d& start : FindStarts(before.cuboid(), after.cuboid())) {
    const Eigen::Isometry3d T_world_guess = start * T_cuboid_object;
    const Registration registration =
        RegisterPoints(points_world, before.volume(), scale, UprightPoseOf(T_world_guess));
    ShapeMatch match;
    match.T_world_object = registration.T_correction.inverse() * T_world_guess;
    match.overlap =
        CompareSurfaces(after, before, match.T_world_object.inverse() * T_world_after, scale);
    if (match.confidence() > best.confidence()) best = match;
  }
  return best;
}

}  // namespace steadymap
