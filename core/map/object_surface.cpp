#include "core/map/object_surface.h"

#include <algorithm>
#include <cmath>

#include "core/volume/voxel_index.h"

namespace steadymap {
namespace {

// Less than this was hardly seen: a sliver at a depth edge, not a surface.
constexpr float kMinWeight = 0.05F;

// Points of a plane across a leaf, about.
constexpr std::size_t kPlanePoints = std::size_t{kLeafSide} * kLeafSide;

/// Gradient of the distance at a voxel from the voxels of its own leaf, so that a leaf's points
/// depend on nothing else. Zero where no neighbour is known along an axis.
Eigen::Vector3f GradientAt(const LeafView& leaf, std::size_t offset) {
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
    gradient[axis] = (leaf.distance_m[high] - leaf.distance_m[low]) / static_cast<float>(voxels);
  }
  return gradient;
}

SurfaceLeaf ExtractPoints(LeafOrigin origin, const LeafView& leaf, const VoxelScale& scale) {
  SurfaceLeaf surface{origin, {}};
  surface.points.reserve(kPlanePoints);
  const auto voxel_size_m = static_cast<float>(scale.voxel_size_m);
  for (std::size_t offset = 0; offset < kLeafVoxels; ++offset) {
    const float distance_m = leaf.distance_m[offset];
    if (std::abs(distance_m) > 0.5F * voxel_size_m || !IsSet(leaf.observed, offset) ||
        leaf.weight[offset] < kMinWeight) {
      continue;
    }
    const Eigen::Vector3f gradient = GradientAt(leaf, offset);
    const float norm = gradient.norm();
    if (norm < 0.25F * voxel_size_m) continue;
    const Eigen::Vector3f normal = gradient / norm;
    // One voxel of each column along the axis that the surface faces.
    if (std::abs(distance_m) > 0.5F * voxel_size_m * normal.cwiseAbs().maxCoeff()) continue;
    const Eigen::Vector3f centre = VoxelIndexAt(origin, offset).cast<float>();
    surface.points.push_back(
        {centre * voxel_size_m - normal * distance_m, normal, EvidenceCellOf(offset)});
  }
  // The points stay as long as the object: room for more of them would add up.
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
