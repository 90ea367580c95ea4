#include "core/objects/shape_match.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/registration/registration.h"
#include "core/volume/tsdf_sample.h"

namespace steadymap {
namespace {

// Starts are ranked by this many points, and the best ones are registered.
constexpr std::size_t kMaxRankingPoints = 200;
constexpr std::size_t kMaxRegisteredStarts = 4;

/// Returns the shifts along one axis that give two cuboids a side in common, or their middles. The
/// registration finds shifts up to its search distance by itself.
std::vector<double> ShiftsOf(double old_side_m, double new_side_m) {
  const double half_m = 0.5 * (new_side_m - old_side_m);
  if (2.0 * std::abs(half_m) < RegistrationParameters().search_distance_m) return {0.0};
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

/// Returns how close points are to a surface, from 0 at the truncation distance to 1.
double ClosenessOf(const std::vector<Eigen::Vector3d>& points_world,
                   const Eigen::Isometry3d& T_object_world,
                   TsdfSampler* sampler) {
  const std::size_t stride = points_world.size() / kMaxRankingPoints + 1;
  const double truncation_m = sampler->scale().truncation_m;
  double closeness = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < points_world.size(); i += stride) {
    ++count;
    double distance_m = 0.0;
    if (!sampler->SampleNearest(T_object_world * points_world[i], &distance_m)) continue;
    closeness += std::max(0.0, 1.0 - std::abs(distance_m) / truncation_m);
  }
  return count == 0 ? 0.0 : closeness / static_cast<double>(count);
}

/// Returns the poses of `before` from which its surface is closest to `points_world`.
std::vector<Eigen::Isometry3d> FindBestStarts(const TrackedObject& before,
                                              const std::vector<Eigen::Vector3d>& points_world,
                                              const Cuboid& new_cuboid,
                                              const VoxelScale& scale) {
  const Eigen::Isometry3d T_cuboid_object =
      before.cuboid().T_world_cuboid().inverse() * before.state().T_world_object.ToIsometry();
  TsdfSampler sampler(before.volume(), scale);
  std::vector<std::pair<double, Eigen::Isometry3d>> ranked;
  for (const Eigen::Isometry3d& start : FindStarts(before.cuboid(), new_cuboid)) {
    const Eigen::Isometry3d T_world_object = start * T_cuboid_object;
    ranked.emplace_back(ClosenessOf(points_world, T_world_object.inverse(), &sampler),
                        T_world_object);
  }
  std::stable_sort(
      ranked.begin(), ranked.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  ranked.resize(std::min(ranked.size(), kMaxRegisteredStarts));
  std::vector<Eigen::Isometry3d> starts;
  starts.reserve(ranked.size());
  for (const auto& [closeness, start] : ranked) starts.push_back(start);
  return starts;
}

}  // namespace

UprightPose UprightPoseOf(const Eigen::Isometry3d& T_world_object) {
  const Eigen::Matrix3d R_world_object = T_world_object.linear();
  return {T_world_object.translation(), std::atan2(R_world_object(1, 0), R_world_object(0, 0))};
}

ShapeMatch MatchShapes(const TrackedObject& before,
                       const TrackedObject& after,
                       const FreeSpaceSince& free_space,
                       const SurfaceMatchParameters& parameters,
                       const VoxelScale& scale,
                       double max_step_m) {
  const std::vector<Eigen::Vector3d> points_world = after.SurfaceInWorld();
  const double foot_m =
      before.cuboid().lowest_m() - before.state().T_world_object.position_world.z();
  const Eigen::Isometry3d T_world_after = after.state().T_world_object.ToIsometry();
  ShapeMatch best;
  for (const Eigen::Isometry3d& T_world_guess :
       FindBestStarts(before, points_world, after.cuboid(), scale)) {
    const Registration registration =
        RegisterPoints(points_world, before.volume(), scale, UprightPoseOf(T_world_guess));
    ShapeMatch match;
    match.T_world_object = registration.T_correction.inverse() * T_world_guess;
    const double step_m =
        match.T_world_object.translation().z() + foot_m - after.cuboid().lowest_m();
    if (std::abs(step_m) > max_step_m) continue;
    match.overlap = CompareSurfaces(
        after, before, match.T_world_object.inverse() * T_world_after, parameters, scale);
    if (match.overlap.known_close_share() > best.overlap.known_close_share()) best = match;
  }
  best.reverse_overlap = CompareSurfaces(
      before, after, T_world_after.inverse() * best.T_world_object, parameters, scale, &free_space);
  return best;
}

}  // namespace steadymap
