#include "core/map/object_surface.h"

#include <algorithm>
#include <cmath>

#include "core/volume/voxel_index.h"

namespace steadymap {
namespace {

// A lower weight indicates a fragment at a depth edge, not a surface.
constexpr float kMinWeight = 0.05F;

// Approximate number of points of a plane through a leaf.
constexpr std::size_t kPlanePoints = std::size_t{kLeafSide} * kLeafSide;

/// Computes the gradient of the distance at a voxel from the voxels of its own leaf only, so that
/// the points of a leaf depend only on the leaf. Zero along an axis without observed neighbours.
Eigen::Vector3f GradientAt(const LeafView& leaf, float distance_step_m, std::size_t offset) {
  constexpr std::size_t kStrides[3] = {64, 8, 1};
  Eigen::Vector3f gradient = Eigen::Vector3f::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    const std::size_t stride = kStrides[axis];
    const std::size_t place = offset / stride % kLeafSide;
    std::size_t low = offset;
    std::size_t high = offset;
    if (place > 0 && IsSet(leaf.observed, offset - stride)) low -= stride;
    if (place + 1 < kLeafSide && IsSet(leaf.observed, offset + stride)) high += stride;
    if (low == high) continue;
    const std::size_t voxels = (high - low) / stride;
    gradient[axis] = (leaf.voxels[high].distance_m(distance_step_m) -
                      leaf.voxels[low].distance_m(distance_step_m)) /
                     static_cast<float>(voxels);
  }
  return gradient;
}

SurfaceLeaf ExtractPoints(LeafOrigin origin, const LeafView& leaf, const VoxelScale& scale) {
  SurfaceLeaf surface{origin, {}};
  surface.points.reserve(kPlanePoints);
  const auto voxel_size_m = static_cast<float>(scale.voxel_size_m);
  const float distance_step_m = scale.distance_step_m();
  for (std::size_t offset = 0; offset < kLeafVoxels; ++offset) {
    const float distance_m = leaf.voxels[offset].distance_m(distance_step_m);
    if (std::abs(distance_m) > 0.5F * voxel_size_m || !IsSet(leaf.observed, offset) ||
        leaf.voxels[offset].weight() < kMinWeight) {
      continue;
    }
    const Eigen::Vector3f gradient = GradientAt(leaf, distance_step_m, offset);
    const float norm = gradient.norm();
    if (norm < 0.25F * voxel_size_m) continue;
    const Eigen::Vector3f normal = gradient / norm;
    // Selects one voxel of each column along the dominant axis of the normal.
    if (std::abs(distance_m) > 0.5F * voxel_size_m * normal.cwiseAbs().maxCoeff()) continue;
    const Eigen::Vector3f centre = VoxelIndexAt(origin, offset).cast<float>();
    surface.points.push_back(
        {centre * voxel_size_m - normal * distance_m, normal, static_cast<std::uint16_t>(offset)});
  }
  // The points stay in memory as long as the object, so spare capacity would accumulate.
  surface.points.shrink_to_fit();
  return surface;
}

std::size_t PointBytesOf(const SurfaceLeaf& leaf) {
  return leaf.points.capacity() * sizeof(SurfaceVoxel);
}

bool IsLeafBefore(const SurfaceLeaf& leaf, LeafOrigin origin) { return leaf.origin < origin; }

}  // namespace

void ObjectSurface::Update(const TsdfGrid& volume,
                           const VoxelScale& scale,
                           std::span<const LeafOrigin> origins) {
  for (const LeafOrigin& origin : origins) {
    const LeafView view = volume.FindLeaf(origin);
    SurfaceLeaf surface{origin, {}};
    if (view) surface = ExtractPoints(origin, view, scale);
    const auto place = std::lower_bound(leaves_.begin(), leaves_.end(), origin, IsLeafBefore);
    const bool is_known = place != leaves_.end() && place->origin == origin;
    if (is_known) point_bytes_ -= PointBytesOf(*place);
    point_bytes_ += PointBytesOf(surface);
    if (surface.points.empty()) {
      if (is_known) leaves_.erase(place);
    } else if (is_known) {
      *place = std::move(surface);
    } else {
      leaves_.insert(place, std::move(surface));
    }
  }
}

void ObjectSurface::Rebuild(const TsdfGrid& volume, const VoxelScale& scale) {
  leaves_.clear();
  point_bytes_ = 0;
  volume.ForEachLeaf([&](LeafOrigin origin, const LeafView& view) {
    SurfaceLeaf surface = ExtractPoints(origin, view, scale);
    point_bytes_ += PointBytesOf(surface);
    if (!surface.points.empty()) leaves_.push_back(std::move(surface));
  });
  std::sort(leaves_.begin(), leaves_.end(), [](const SurfaceLeaf& a, const SurfaceLeaf& b) {
    return a.origin < b.origin;
  });
}

std::size_t ObjectSurface::point_count() const {
  std::size_t count = 0;
  for (const SurfaceLeaf& leaf : leaves_) count += leaf.points.size();
  return count;
}

}  // namespace steadymap
