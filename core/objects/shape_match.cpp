#include "core/objects/shape_match.h"

#include <cmath>
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

}  // namespace

UprightPose UprightPoseOf(const Eigen::Isometry3d& T_world_object) {
  const Eigen::Matrix3d R_world_object = T_world_object.linear();
  return {T_world_object.translation(), std::atan2(R_world_object(1, 0), R_world_object(0, 0))};
}

ShapeMatch MatchShapes(const TrackedObject& before,
                       const TrackedObject& after,
                       const VoxelScale& scale) {
  const Cuboid& old_cuboid = before.cuboid();
  const Cuboid& new_cuboid = after.cuboid();
  const std::vector<Eigen::Vector3d> points_world = after.SurfaceInWorld();
  const Eigen::Isometry3d T_cuboid_object =
      old_cuboid.T_world_cuboid().inverse() * before.state().T_world_object.ToIsometry();
  ShapeMatch best;
  const auto try_start = [&](const Eigen::Isometry3d& T_world_guess) {
    const Registration registration =
        RegisterPoints(points_world, before.volume(), scale, UprightPoseOf(T_world_guess));
    ShapeMatch match;
    match.T_world_object = registration.T_correction.inverse() * T_world_guess;
    match.overlap =
        CompareSurfaces(after,
                        before,
                        match.T_world_object.inverse() * after.state().T_world_object.ToIsometry(),
                        scale);
    if (match.confidence() > best.confidence()) best = match;
  };
  for (int quarter = 0; quarter < 4; ++quarter) {
    const Eigen::AngleAxisd turn(0.5 * M_PI * quarter, Eigen::Vector3d::UnitZ());
    const bool is_across = quarter % 2 == 1;
    const double old_x_m = is_across ? old_cuboid.size_m.y() : old_cuboid.size_m.x();
    const double old_y_m = is_across ? old_cuboid.size_m.x() : old_cuboid.size_m.y();
    for (const double x_m : ShiftsOf(old_x_m, new_cuboid.size_m.x())) {
      for (const double y_m : ShiftsOf(old_y_m, new_cuboid.size_m.y())) {
        for (const double z_m : ShiftsOf(old_cuboid.size_m.z(), new_cuboid.size_m.z())) {
          try_start(new_cuboid.T_world_cuboid() * Eigen::Translation3d(x_m, y_m, z_m) * turn *
                    T_cuboid_object);
        }
      }
    }
  }
  return best;
}

}  // namespace steadymap
