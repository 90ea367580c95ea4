#include "core/objects/surface_relations.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/volume/tsdf_sample.h"

namespace steadymap {
namespace {

// Points whose view is tested; they determine a share to two percent.
constexpr std::size_t kMaxTestedPoints = 1000;

/// The surface of another object in the frame of an object.
class OtherSurface {
 public:
  OtherSurface(const TrackedObject& object, const TrackedObject& other, const VoxelScale& scale)
      : T_other_object_(other.state().T_world_object.ToIsometry().inverse() *
                        object.state().T_world_object.ToIsometry()),
        sampler_(other.volume(), scale),
        voxel_size_m_(scale.voxel_size_m) {}

  /// True if a point is within a voxel of the surface.
  bool Has(const Eigen::Vector3d& position_object) {
    double distance_m = 0.0;
    return sampler_.SampleNearest(T_other_object_ * position_object, &distance_m) &&
           std::abs(distance_m) <= voxel_size_m_;
  }

  /// True if a point is near the surface, also up to `reach_m` beyond its edge.
  bool HasNear(const Eigen::Vector3d& position_object, double reach_m) {
    if (Has(position_object)) return true;
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d step = reach_m * Eigen::Vector3d::Unit(axis);
      if (Has(position_object + step) || Has(position_object - step)) return true;
    }
    return false;
  }

 private:
  Eigen::Isometry3d T_other_object_;
  TsdfSampler sampler_;
  double voxel_size_m_;
};

/// True if the space just behind a surface is free.
bool IsFreeBehind(const SurfaceVoxel& point,
                  const Eigen::Isometry3d& T_world_object,
                  const FreeSpaceSince& free_space) {
  const Eigen::Vector3d behind = point.position_object.cast<double>() -
                                 free_space.cell_size_m() * point.normal_object.cast<double>();
  return free_space.IsFree(T_world_object * behind);
}

}  // namespace

std::size_t CountExplainedCells(const TrackedObject& object,
                                const std::vector<const TrackedObject*>& others,
                                double reach_m,
                                const VoxelScale& scale) {
  const Box reach_world = Grow(object.BoundsInWorld(), scale.truncation_m);
  std::vector<OtherSurface> surfaces;
  for (const TrackedObject* other : others) {
    if (reach_world.intersects(other->BoundsInWorld())) {
      surfaces.emplace_back(object, *other, scale);
    }
  }
  if (surfaces.empty()) return 0;
  std::size_t count = 0;
  for (const SurfaceLeaf& leaf : object.surface().leaves()) {
    const LeafEvidence* evidence = object.state().evidence.FindLeaf(leaf.origin);
    if (evidence == nullptr) continue;
    std::array<bool, kEvidenceCells> is_explained{};
    for (const SurfaceVoxel& point : leaf.points) {
      if (evidence->score[point.cell()] <= 0 || is_explained[point.cell()]) continue;
      const Eigen::Vector3d position = point.position_object.cast<double>();
      is_explained[point.cell()] =
          std::any_of(surfaces.begin(), surfaces.end(), [&](OtherSurface& surface) {
            return surface.HasNear(position, reach_m);
          });
    }
    count += static_cast<std::size_t>(std::count(is_explained.begin(), is_explained.end(), true));
  }
  return count;
}

double HiddenShare(const TrackedObject& object,
                   const TrackedObject& other,
                   const VoxelScale& scale) {
  OtherSurface surface(object, other, scale);
  // From beyond what one surface measures, to the far side of the other object.
  const auto first_step = static_cast<int>(std::ceil(scale.truncation_m / scale.voxel_size_m));
  const auto last_step =
      static_cast<int>(std::ceil(other.cuboid().size_m.norm() / scale.voxel_size_m));
  const auto is_hidden = [&](const SurfaceVoxel& point) {
    const Eigen::Vector3d position = point.position_object.cast<double>();
    const Eigen::Vector3d step = scale.voxel_size_m * point.normal_object.cast<double>();
    for (int i = first_step; i <= last_step; ++i) {
      if (surface.Has(position + i * step)) return true;
    }
    return false;
  };
  const std::size_t stride = object.surface().point_count() / kMaxTestedPoints + 1;
  std::size_t index = 0;
  std::size_t hidden = 0;
  std::size_t tested = 0;
  for (const SurfaceLeaf& leaf : object.surface().leaves()) {
    for (const SurfaceVoxel& point : leaf.points) {
      if (index++ % stride != 0) continue;
      ++tested;
      if (is_hidden(point)) ++hidden;
    }
  }
  return tested == 0 ? 0.0 : static_cast<double>(hidden) / static_cast<double>(tested);
}

double FreeShareOf(const TrackedObject& object, const FreeSpaceSince& free_space) {
  const Eigen::Isometry3d T_world_object = object.state().T_world_object.ToIsometry();
  std::size_t free = 0;
  for (const SurfaceLeaf& leaf : object.surface().leaves()) {
    for (const SurfaceVoxel& point : leaf.points) {
      if (IsFreeBehind(point, T_world_object, free_space)) ++free;
    }
  }
  const std::size_t count = object.surface().point_count();
  return count == 0 ? 0.0 : static_cast<double>(free) / static_cast<double>(count);
}

void DoubtFreeCells(const TrackedObject& object,
                    const FreeSpaceSince& free_space,
                    ObjectEvidence* evidence) {
  const Eigen::Isometry3d T_world_object = object.state().T_world_object.ToIsometry();
  for (const SurfaceLeaf& leaf : object.surface().leaves()) {
    std::array<int, kEvidenceCells> balance{};
    for (const SurfaceVoxel& point : leaf.points) {
      balance[point.cell()] += IsFreeBehind(point, T_world_object, free_space) ? 1 : -1;
    }
    if (std::none_of(balance.begin(), balance.end(), [](int value) { return value > 0; })) continue;
    LeafEvidence& scores = evidence->MutableLeaf(leaf.origin);
    for (std::size_t cell = 0; cell < kEvidenceCells; ++cell) {
      if (balance[cell] > 0) scores.score[cell] = -1;
    }
  }
}

}  // namespace steadymap
