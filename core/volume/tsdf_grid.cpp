#include "core/volume/tsdf_grid.h"

#include <algorithm>
#include <cstdint>
#include <type_traits>

#include "core/volume/tsdf_trees.h"

namespace steadymap {
namespace {

using WordLeaf = WordTree::LeafNodeType;

static_assert(WordLeaf::SIZE == kLeafVoxels);
static_assert(sizeof(openvdb::Int32) == sizeof(std::uint32_t));
static_assert(sizeof(Voxel) == sizeof(std::uint32_t) && std::is_standard_layout_v<Voxel>);

LeafMask MaskOf(const WordLeaf& leaf) {
  LeafMask mask;
  for (int word = 0; word < kLeafSide; ++word) {
    mask[static_cast<std::size_t>(word)] =
        leaf.getValueMask().getWord<std::uint64_t>(static_cast<openvdb::Index>(word));
  }
  return mask;
}

// This code uses unsigned 32-bit colours and voxels of one unsigned word, OpenVDB's stock types
// signed words. The types may alias.
const std::uint32_t* ColorsOf(const WordLeaf* leaf) {
  return leaf == nullptr ? nullptr : reinterpret_cast<const std::uint32_t*>(leaf->buffer().data());
}

std::uint32_t* ColorsOf(WordLeaf* leaf) {
  return leaf == nullptr ? nullptr : reinterpret_cast<std::uint32_t*>(leaf->buffer().data());
}

const Voxel* VoxelsOf(const WordLeaf& leaf) {
  return reinterpret_cast<const Voxel*>(leaf.buffer().data());
}

Voxel* VoxelsOf(WordLeaf* leaf) { return reinterpret_cast<Voxel*>(leaf->buffer().data()); }

void RemoveLeaf(const openvdb::Coord& coord, WordTree* tree) {
  delete tree->stealNode<WordLeaf>(coord, tree->background(), /*active=*/false);
}

bool IsEmpty(const LeafMask& mask) {
  return std::all_of(mask.begin(), mask.end(), [](std::uint64_t word) { return word == 0; });
}

}  // namespace

void VoxelReader::ForEachLeaf(const std::function<void(LeafOrigin, const LeafView&)>& visit) const {
  VisitLeaves([&visit](LeafOrigin origin, const LeafView& leaf) {
    visit(origin, leaf);
    return true;
  });
}

int VoxelReader::EmptySideAt(LeafOrigin /*origin*/) const { return kLeafSide; }

TsdfGrid::TsdfGrid() : trees_(std::make_unique<Trees>()) {}

TsdfGrid::~TsdfGrid() = default;
TsdfGrid::TsdfGrid(TsdfGrid&&) noexcept = default;
TsdfGrid& TsdfGrid::operator=(TsdfGrid&&) noexcept = default;

std::unique_ptr<TsdfGrid> TsdfGrid::Clone() const {
  auto clone = std::make_unique<TsdfGrid>();
  clone->trees_ = std::make_unique<Trees>(*trees_);
  return clone;
}

LeafView TsdfGrid::FindLeaf(LeafOrigin origin) const {
  const openvdb::Coord coord = ToCoord(origin);
  const WordLeaf* leaf = trees_->voxels.probeConstLeaf(coord);
  if (leaf == nullptr) return {};
  return {VoxelsOf(*leaf), ColorsOf(trees_->color.probeConstLeaf(coord)), MaskOf(*leaf)};
}

bool TsdfGrid::VisitLeaves(const std::function<bool(LeafOrigin, const LeafView&)>& visit) const {
  for (WordTree::LeafCIter leaf = trees_->voxels.cbeginLeaf(); leaf; ++leaf) {
    const openvdb::Coord& coord = leaf->origin();
    const LeafOrigin origin{coord.x(), coord.y(), coord.z()};
    if (!visit(origin, FindLeaf(origin))) return false;
  }
  return true;
}

std::size_t TsdfGrid::leaf_count() const { return trees_->voxels.leafCount(); }

int TsdfGrid::EmptySideAt(LeafOrigin origin) const {
  // The search for the leaf ends at the root, or in an inner node.
  const bool has_node = trees_->voxels.getValueDepth(ToCoord(origin)) > 0;
  return has_node ? kLeafSide : kLeafSide * kLeafSide;
}

LeafEdit TsdfGrid::EditLeaf(LeafOrigin origin, bool with_color) {
  const openvdb::Coord coord = ToCoord(origin);
  WordLeaf* leaf = trees_->voxels.probeLeaf(coord);
  if (leaf == nullptr) return {};
  WordLeaf* color = with_color ? trees_->color.touchLeaf(coord) : trees_->color.probeLeaf(coord);
  return {VoxelsOf(leaf), ColorsOf(color), MaskOf(*leaf)};
}

void TsdfGrid::SetObserved(LeafOrigin origin, const LeafMask& observed) {
  trees_->voxels.probeLeaf(ToCoord(origin))->setValueMask(ToNodeMask(observed));
}

void TsdfGrid::StoreLeaf(LeafOrigin origin, const LeafVoxels& voxels) {
  const openvdb::Coord coord = ToCoord(origin);
  if (IsEmpty(voxels.observed)) {
    RemoveLeaf(coord, &trees_->voxels);
    RemoveLeaf(coord, &trees_->color);
    return;
  }
  WordLeaf* leaf = trees_->voxels.touchLeaf(coord);
  std::copy(voxels.voxels.begin(), voxels.voxels.end(), VoxelsOf(leaf));
  leaf->setValueMask(ToNodeMask(voxels.observed));
  if (voxels.has_color) {
    std::copy(voxels.color.begin(), voxels.color.end(), ColorsOf(trees_->color.touchLeaf(coord)));
  } else {
    RemoveLeaf(coord, &trees_->color);
  }
}

void TsdfGrid::LoadLeaf(LeafOrigin origin, LeafVoxels* voxels) const {
  CopyLeaf(FindLeaf(origin), voxels);
}

std::size_t TsdfGrid::CountObservedVoxels() const {
  std::size_t count = 0;
  for (WordTree::LeafCIter leaf = trees_->voxels.cbeginLeaf(); leaf; ++leaf) {
    count += leaf->getValueMask().countOn();
  }
  return count;
}

std::size_t TsdfGrid::memory_bytes() const {
  return static_cast<std::size_t>(trees_->voxels.memUsage() + trees_->color.memUsage());
}

}  // namespace steadymap
