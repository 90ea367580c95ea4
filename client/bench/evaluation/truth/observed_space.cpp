#include "client/bench/evaluation/truth/observed_space.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace steadymap {
namespace {

constexpr int kBlockShift = 3;
constexpr int kBlockMask = 7;

// With this ray spacing at the far end, in voxels, rays miss no relevant voxel; and at most
// kMaxStridePx pixels apart.
constexpr double kRaySpacingVoxels = 0.5;
constexpr int kMaxStridePx = 4;

VoxelIndex BlockOf(const VoxelIndex& voxel) {
  return {voxel.x >> kBlockShift, voxel.y >> kBlockShift, voxel.z >> kBlockShift};
}

std::size_t OffsetInBlock(const VoxelIndex& voxel) {
  return static_cast<std::size_t>(((voxel.x & kBlockMask) << (2 * kBlockShift)) |
                                  ((voxel.y & kBlockMask) << kBlockShift) | (voxel.z & kBlockMask));
}

}  // namespace

ObservedSpace::ObservedSpace(double voxel_size_m, double max_depth_m)
    : voxel_size_m_(voxel_size_m), max_depth_m_(max_depth_m) {}

void ObservedSpace::AddView(const DepthView& view) {
  const double wanted_px = kRaySpacingVoxels * voxel_size_m_ * view.camera.fx / max_depth_m_;
  const int stride_px = std::clamp(static_cast<int>(wanted_px), 1, kMaxStridePx);
  const Eigen::Vector3d eye_world = view.T_world_camera.translation();
  for (int v = stride_px / 2; v < view.camera.height_px; v += stride_px) {
    for (int u = stride_px / 2; u < view.camera.width_px; u += stride_px) {
      const auto depth_m = static_cast<double>(view.depth_m.At(u, v));
      if (!(depth_m > 0.0)) continue;
      const Eigen::Vector3d end_camera = view.camera.Ray(u, v) * std::min(depth_m, max_depth_m_);
      CastRay(eye_world, view.T_world_camera * end_camera);
    }
  }
}

// The voxel traversal of Amanatides and Woo ("A Fast Voxel Traversal Algorithm for Ray Tracing",
// 1987), in voxel units.
void ObservedSpace::CastRay(const Eigen::Vector3d& from_world, const Eigen::Vector3d& to_world) {
  const Eigen::Array3d from = from_world.array() / voxel_size_m_;
  const Eigen::Array3d span = to_world.array() / voxel_size_m_ - from;
  Eigen::Array3i voxel = from.round().cast<int>();
  const Eigen::Array3i last = (from + span).round().cast<int>();
  Eigen::Array3i step;
  Eigen::Array3d share_a_voxel;  // Share of the ray per voxel along each axis.
  Eigen::Array3d next_share;     // Share of the ray up to the next voxel along each axis.
  for (int axis = 0; axis < 3; ++axis) {
    step[axis] = span[axis] < 0 ? -1 : 1;
    const double length = std::abs(span[axis]);
    const bool moves = length > 1e-12;
    share_a_voxel[axis] = moves ? 1.0 / length : std::numeric_limits<double>::infinity();
    const double to_border = 0.5 + (voxel[axis] - from[axis]) * step[axis];
    next_share[axis] = moves ? to_border / length : std::numeric_limits<double>::infinity();
  }
  const int steps = (last - voxel).abs().sum();
  MarkObserved({voxel[0], voxel[1], voxel[2]});
  for (int i = 0; i < steps; ++i) {
    int axis = next_share[0] < next_share[1] ? 0 : 1;
    if (next_share[2] < next_share[axis]) axis = 2;
    voxel[axis] += step[axis];
    next_share[axis] += share_a_voxel[axis];
    MarkObserved({voxel[0], voxel[1], voxel[2]});
  }
}

void ObservedSpace::MarkObserved(const VoxelIndex& voxel) {
  const VoxelIndex block = BlockOf(voxel);
  if (last_block_ == nullptr || block != last_index_) {
    last_block_ = &blocks_.try_emplace(block, Block{}).first->second;
    last_index_ = block;
  }
  (*last_block_)[OffsetInBlock(voxel)] = 1;
}

bool ObservedSpace::IsObserved(const VoxelIndex& voxel) const {
  const auto found = blocks_.find(BlockOf(voxel));
  return found != blocks_.end() && found->second[OffsetInBlock(voxel)] != 0;
}

std::size_t ObservedSpace::observed_count() const {
  std::size_t count = 0;
  ForEach([&count](const VoxelIndex&) { ++count; });
  return count;
}

void ObservedSpace::ForEach(const std::function<void(const VoxelIndex&)>& visit) const {
  for (const auto& [index, block] : blocks_) {
    for (int i = 0; i < static_cast<int>(block.size()); ++i) {
      if (block[static_cast<std::size_t>(i)] == 0) continue;
      visit({index.x * kBlockSide + (i >> (2 * kBlockShift)),
             index.y * kBlockSide + ((i >> kBlockShift) & kBlockMask),
             index.z * kBlockSide + (i & kBlockMask)});
    }
  }
}

}  // namespace steadymap
