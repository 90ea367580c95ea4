#include "core/query/vdb_leaves.h"

#include <algorithm>
#include <tuple>

#include "core/query/file_encoder.h"
#include "core/volume/voxel_index.h"

namespace steadymap {
namespace {

// Sides of the two kinds of inner nodes in OpenVDB's stock trees, voxels.
constexpr std::int32_t kTopNodeSide = 4096;
constexpr std::int32_t kMiddleNodeSide = 128;

// A leaf at this distance from the box has no voxel in it despite rounding errors, metres.
constexpr double kBoxMarginM = 1e-6;

auto TreeOrder(const LeafOrigin& leaf) {
  const auto node = [&leaf](std::int32_t side) {
    return LeafOrigin{leaf.x & ~(side - 1), leaf.y & ~(side - 1), leaf.z & ~(side - 1)};
  };
  return std::tuple(node(kTopNodeSide), node(kMiddleNodeSide), leaf);
}

void SortForTree(std::vector<MaskedLeaf>* leaves) {
  std::sort(leaves->begin(), leaves->end(), [](const MaskedLeaf& a, const MaskedLeaf& b) {
    return TreeOrder(a.origin) < TreeOrder(b.origin);
  });
}

bool HasVoxels(const LeafMask& mask) { return mask != LeafMask{}; }

/// Returns the bits of `mask` for which `keeps(offset)` is true.
template <typename Predicate>
LeafMask Filter(const LeafMask& mask, const Predicate& keeps) {
  LeafMask kept{};
  for (std::size_t offset = 0; offset < kLeafVoxels; ++offset) {
    if (IsSet(mask, offset) && keeps(offset)) {
      SetBit(offset, &kept);
    }
  }
  return kept;
}

/// Selects the voxels of one volume.
class VoxelChoice {
 public:
  VoxelChoice(const PlacedVolume& volume, const VoxelScale& scale, const Box* box_world)
      : volume_(volume), scale_(scale), box_world_(box_world) {
    if (box_world == nullptr) return;
    reach_world_ =
        Box(box_world->min().array() - kBoxMarginM, box_world->max().array() + kBoxMarginM);
  }

  LeafMask Observed(LeafOrigin origin, const LeafView& leaf) const {
    if (box_world_ == nullptr) return leaf.observed;
    if (!LeafTouches(volume_, origin, scale_, reach_world_)) return {};
    return Filter(leaf.observed, [&](std::size_t offset) {
      const Eigen::Vector3d voxel = VoxelIndexAt(origin, offset).cast<double>();
      return box_world_->contains(
          Eigen::Vector3d(volume_.T_world_volume * (voxel * scale_.voxel_size_m)));
    });
  }

  static LeafMask Colored(const LeafView& leaf, const LeafMask& observed) {
    if (leaf.color == nullptr) return {};
    return Filter(observed, [&](std::size_t offset) { return (leaf.color[offset] >> 24) != 0; });
  }

 private:
  const PlacedVolume& volume_;
  const VoxelScale scale_;
  const Box* const box_world_;
  Box reach_world_;  ///< The box plus `kBoxMarginM`.
};

}  // namespace

absl::StatusOr<VdbLeaves> ChooseVdbLeaves(const PlacedVolume& volume,
                                          const VoxelScale& scale,
                                          const Box* box_world,
                                          const Cancellation& cancellation) {
  VdbLeaves leaves;
  const VoxelChoice choice(volume, scale, box_world);
  const bool finished = volume.voxels->VisitLeaves([&](LeafOrigin origin, const LeafView& leaf) {
    const LeafMask observed = choice.Observed(origin, leaf);
    if (HasVoxels(observed)) leaves.observed.push_back({origin, observed});
    const LeafMask colored = VoxelChoice::Colored(leaf, observed);
    if (HasVoxels(colored)) leaves.colored.push_back({origin, colored});
    return !cancellation.IsCancelled();
  });
  if (!finished) return CancelledFileError();
  SortForTree(&leaves.observed);
  SortForTree(&leaves.colored);
  return leaves;
}

absl::StatusOr<bool> HasVdbColor(const PlacedVolume& volume,
                                 const VoxelScale& scale,
                                 const Box* box_world,
                                 const Cancellation& cancellation) {
  bool has_color = false;
  const VoxelChoice choice(volume, scale, box_world);
  const bool finished = volume.voxels->VisitLeaves([&](LeafOrigin origin, const LeafView& leaf) {
    if (leaf.color != nullptr) {
      has_color = HasVoxels(VoxelChoice::Colored(leaf, choice.Observed(origin, leaf)));
    }
    return !has_color && !cancellation.IsCancelled();
  });
  if (!finished && !has_color) return CancelledFileError();
  return has_color;
}

}  // namespace steadymap
