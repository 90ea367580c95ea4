#include "core/volume/tsdf_grid.h"

#include <algorithm>
#include <utility>

#include "core/volume/tsdf_trees.h"

namespace steadymap {
namespace {

using FloatLeaf = FloatTree::LeafNodeType;
using ColorLeaf = ColorTree::LeafNodeType;

static_assert(FloatLeaf::SIZE == kLeafVoxels);
static_assert(sizeof(openvdb::Int32) == sizeof(std::uint32_t));

LeafMask MaskOf(const FloatLeaf& leaf) {
  LeafMask mask;
  for (int word = 0; word < kLeafSide; ++word) {
    mask[static_cast<std::size_t>(word)] =
        leaf.getValueMask().getWord<std::uint64_t>(static_cast<openvdb::Index>(word));
  }
  return mask;
}

// This code uses unsigned 32-bit colours, OpenVDB's stock types signed ones. The two types may
// alias.
const std::uint32_t* Unsigned(const openvdb::Int32* colors) {
  return reinterpret_cast<const std::uint32_t*>(colors);
}

std::uint32_t* Unsigned(openvdb::Int32* colors) { return reinterpret_cast<std::uint32_t*>(colors); }

template <typename Tree>
void RemoveLeaf(const openvdb::Coord& coord, Tree* tree) {
  using Leaf = typename Tree::LeafNodeType;
  delete tree->template stealNode<Leaf>(coord, tree->background(), /*active=*/false);
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
  const FloatLeaf* distance = trees_->distance.probeConstLeaf(coord);
  if (distance == nullptr) return {};
  const ColorLeaf* color = trees_->color.probeConstLeaf(coord);
  return {distance->buffer().data(),
          trees_->weight.probeConstLeaf(coord)->buffer().data(),
          color == nullptr ? nullptr : Unsigned(color->buffer().data()),
          MaskOf(*distance)};
}

bool TsdfGrid::VisitLeaves(const std::function<bool(LeafOrigin, const LeafView&)>& visit) const {
  for (FloatTree::LeafCIter leaf = trees_->distance.cbeginLeaf(); leaf; ++leaf) {
    const openvdb::Coord& coord = leaf->origin();
    const LeafOrigin origin{coord.x(), coord.y(), coord.z()};
    if (!visit(origin, FindLeaf(origin))) return false;
  }
  return true;
}

std::size_t TsdfGrid::leaf_count() const { return trees_->distance.leafCount(); }

int TsdfGrid::EmptySideAt(LeafOrigin origin) const {
  // The depth at which the search for the leaf ends: the root, a node of 512 or a node of 64 voxels
  // per side.
  switch (trees_->distance.getValueDepth(ToCoord(origin))) {
    case 2:
      return kLeafSide;
    case 1:
      return kLeafSide * kLeafSide;
    default:
      return kLeafSide * kLeafSide * kLeafSide;
  }
}

LeafEdit TsdfGrid::EditLeaf(LeafOrigin origin, bool with_color) {
  const openvdb::Coord coord = ToCoord(origin);
  FloatLeaf* distance = trees_->distance.probeLeaf(coord);
  if (distance == nullptr) return {};
  FloatLeaf* weight = trees_->weight.probeLeaf(coord);
  ColorLeaf* color = with_color ? trees_->color.touchLeaf(coord) : trees_->color.probeLeaf(coord);
  return {distance->buffer().data(),
          weight->buffer().data(),
          color == nullptr ? nullptr : Unsigned(color->buffer().data()),
          MaskOf(*distance)};
}

void TsdfGrid::SetObserved(LeafOrigin origin, const LeafMask& observed) {
  const openvdb::Coord coord = ToCoord(origin);
  const LeafNodeMask mask = ToNodeMask(observed);
  trees_->distance.probeLeaf(coord)->setValueMask(mask);
  trees_->weight.probeLeaf(coord)->setValueMask(mask);
}

void TsdfGrid::StoreLeaf(LeafOrigin origin, const LeafVoxels& voxels) {
  const openvdb::Coord coord = ToCoord(origin);
  if (IsEmpty(voxels.observed)) {
    RemoveLeaf(coord, &trees_->distance);
    RemoveLeaf(coord, &trees_->weight);
    RemoveLeaf(coord, &trees_->color);
    return;
  }
  std::copy(voxels.distance_m.begin(),
            voxels.distance_m.end(),
            trees_->distance.touchLeaf(coord)->buffer().data());
  std::copy(
      voxels.weight.begin(), voxels.weight.end(), trees_->weight.touchLeaf(coord)->buffer().data());
  SetObserved(origin, voxels.observed);
  if (voxels.has_color) {
    std::copy(voxels.color.begin(),
              voxels.color.end(),
              Unsigned(trees_->color.touchLeaf(coord)->buffer().data()));
  } else {
    RemoveLeaf(coord, &trees_->color);
  }
}

void TsdfGrid::LoadLeaf(LeafOrigin origin, LeafVoxels* voxels) const {
  CopyLeaf(FindLeaf(origin), voxels);
}

std::size_t TsdfGrid::CountObservedVoxels() const {
  std::size_t count = 0;
  for (FloatTree::LeafCIter leaf = trees_->distance.cbeginLeaf(); leaf; ++leaf) {
    count += leaf->getValueMask().countOn();
  }
  return count;
}

std::size_t TsdfGrid::memory_bytes() const {
  return static_cast<std::size_t>(trees_->distance.memUsage() + trees_->weight.memUsage() +
                                  trees_->color.memUsage());
}

}  // namespace steadymap
