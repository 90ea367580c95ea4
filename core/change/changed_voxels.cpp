#include "core/change/changed_voxels.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <unordered_map>

#include "core/volume/voxel_index.h"

namespace steadymap {
namespace {

using Masks = std::unordered_map<LeafOrigin, LeafMask>;

LeafMask DifferenceOf(const LeafView& before,
                      const LeafView& after,
                      const VoxelScale& scale,
                      const ChangedVoxelParameters& parameters) {
  LeafMask different{};
  ForEachBit(before.observed, [&](std::size_t offset) {
    if (IsSet(after.observed, offset) && IsComparable(before, after, offset, parameters) &&
        IsDifferent(before, after, offset, scale, parameters)) {
      SetBit(offset, &different);
    }
  });
  return different;
}

/// The voxels further before a surface than what counts as a difference.
LeafMask OpenSpaceOf(const LeafView& leaf,
                     const VoxelScale& scale,
                     const ChangedVoxelParameters& parameters) {
  LeafMask open{};
  const double from_m = parameters.min_difference * scale.truncation_m;
  for (std::size_t offset = 0; offset < kLeafVoxels; ++offset) {
    if (IsSet(leaf.observed, offset) &&
        static_cast<double>(scale.distance_m(leaf.voxels[offset])) > from_m) {
      SetBit(offset, &open);
    }
  }
  return open;
}

/// Collects connected voxels of masks.
class VoxelComponentSearch {
 public:
  explicit VoxelComponentSearch(const Masks& different) : different_(different), open_(different) {}

  /// Any voxel of a leaf that belongs to no component yet.
  bool FindOpen(LeafOrigin origin, Eigen::Vector3i* voxel) const {
    const LeafMask& mask = open_.at(origin);
    for (std::size_t word = 0; word < mask.size(); ++word) {
      if (mask[word] == 0) continue;
      *voxel =
          VoxelIndexAt(origin, word * 64 + static_cast<std::size_t>(std::countr_zero(mask[word])));
      return true;
    }
    return false;
  }

  /// The voxels connected to `first`, which are open no more.
  std::vector<Eigen::Vector3i> Take(const Eigen::Vector3i& first) {
    std::vector<Eigen::Vector3i> voxels;
    Close(first, &voxels);
    for (std::size_t next = 0; next < voxels.size(); ++next) {
      const Eigen::Vector3i center = voxels[next];
      for (int i = 0; i < 27; ++i) {
        Close(center + Eigen::Vector3i(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1), &voxels);
      }
    }
    return voxels;
  }

  /// Whether `voxel` belongs to a cube of two voxels a side that all differ or are open space in
  /// `after`: what was freed earlier goes on being part of the change.
  bool IsInCube(const Eigen::Vector3i& voxel, const Masks& open_space) const {
    for (int cube = 0; cube < 8; ++cube) {
      const Eigen::Vector3i lowest = voxel - Eigen::Vector3i(cube >> 2, cube >> 1 & 1, cube & 1);
      bool is_whole = true;
      for (int i = 0; i < 8 && is_whole; ++i) {
        const Eigen::Vector3i corner = lowest + Eigen::Vector3i(i >> 2, i >> 1 & 1, i & 1);
        is_whole = Holds(different_, corner) || Holds(open_space, corner);
      }
      if (is_whole) return true;
    }
    return false;
  }

 private:
  static bool Holds(const Masks& masks, const Eigen::Vector3i& voxel) {
    const auto leaf = masks.find(LeafOf(voxel.x(), voxel.y(), voxel.z()));
    return leaf != masks.end() &&
           IsSet(leaf->second, OffsetInLeaf(voxel.x(), voxel.y(), voxel.z()));
  }

  void Close(const Eigen::Vector3i& voxel, std::vector<Eigen::Vector3i>* voxels) {
    const auto leaf = open_.find(LeafOf(voxel.x(), voxel.y(), voxel.z()));
    if (leaf == open_.end()) return;
    const std::size_t offset = OffsetInLeaf(voxel.x(), voxel.y(), voxel.z());
    if (!IsSet(leaf->second, offset)) return;
    ClearBit(offset, &leaf->second);
    voxels->push_back(voxel);
  }

  const Masks& different_;
  Masks open_;
};

/// What became of the surface at the voxels of a component.
VoxelChange Describe(const std::vector<Eigen::Vector3i>& voxels,
                     const VoxelReader& before,
                     const VoxelReader& after,
                     const VoxelScale& scale,
                     const ChangedVoxelParameters& parameters) {
  VoxelChange change;
  std::map<LeafOrigin, LeafMask> masks;
  for (const Eigen::Vector3i& voxel : voxels) {
    const std::size_t offset = OffsetInLeaf(voxel.x(), voxel.y(), voxel.z());
    SetBit(offset, &masks[LeafOf(voxel.x(), voxel.y(), voxel.z())]);
    change.mean_voxel += voxel.cast<double>();
  }
  change.voxels = voxels.size();
  change.mean_voxel /= static_cast<double>(voxels.size());
  for (const auto& [origin, mask] : masks) {
    change.leaves.push_back({origin, mask});
    const LeafView old_leaf = before.FindLeaf(origin);
    const LeafView new_leaf = after.FindLeaf(origin);
    for (std::size_t offset = 0; offset < kLeafVoxels; ++offset) {
      if (!IsSet(mask, offset)) continue;
      const Voxel now = new_leaf.voxels[offset];
      if (IsFree(now, scale, parameters)) ++change.freed;
      if (now.distance_steps() < old_leaf.voxels[offset].distance_steps()) ++change.taken;
    }
  }
  return change;
}

}  // namespace

bool IsFree(Voxel voxel, const VoxelScale& scale, const ChangedVoxelParameters& parameters) {
  return static_cast<double>(scale.distance_m(voxel)) >= parameters.free_from * scale.truncation_m;
}

bool IsComparable(const LeafView& before,
                  const LeafView& after,
                  std::size_t offset,
                  const ChangedVoxelParameters& parameters) {
  return static_cast<double>(std::min(before.voxels[offset].weight(),
                                      after.voxels[offset].weight())) >= parameters.min_weight;
}

bool IsDifferent(const LeafView& before,
                 const LeafView& after,
                 std::size_t offset,
                 const VoxelScale& scale,
                 const ChangedVoxelParameters& parameters) {
  const double old_m = static_cast<double>(scale.distance_m(before.voxels[offset]));
  const double new_m = static_cast<double>(scale.distance_m(after.voxels[offset]));
  const double band_m = parameters.free_from * scale.truncation_m;
  return std::abs(new_m - old_m) > parameters.min_difference * scale.truncation_m &&
         std::min(std::abs(old_m), std::abs(new_m)) < band_m;
}

std::vector<VoxelChange> FindChanges(const VoxelReader& before,
                                     const VoxelReader& after,
                                     const std::vector<LeafOrigin>& origins,
                                     const VoxelScale& scale,
                                     const ChangedVoxelParameters& parameters) {
  Masks different;
  Masks open_space;
  for (const LeafOrigin& origin : origins) {
    const LeafView old_leaf = before.FindLeaf(origin);
    const LeafView new_leaf = after.FindLeaf(origin);
    if (!old_leaf || !new_leaf) continue;
    const LeafMask mask = DifferenceOf(old_leaf, new_leaf, scale, parameters);
    if (mask == LeafMask{}) continue;
    different.emplace(origin, mask);
    open_space.emplace(origin, OpenSpaceOf(new_leaf, scale, parameters));
  }
  std::vector<VoxelChange> changes;
  VoxelComponentSearch search(different);
  for (const LeafOrigin& origin : origins) {
    if (!different.contains(origin)) continue;
    Eigen::Vector3i first;
    while (search.FindOpen(origin, &first)) {
      const std::vector<Eigen::Vector3i> voxels = search.Take(first);
      if (voxels.size() >= parameters.min_voxels &&
          std::any_of(voxels.begin(), voxels.end(), [&](const Eigen::Vector3i& voxel) {
            return search.IsInCube(voxel, open_space);
          })) {
        changes.push_back(Describe(voxels, before, after, scale, parameters));
      }
    }
  }
  return changes;
}

}  // namespace steadymap
