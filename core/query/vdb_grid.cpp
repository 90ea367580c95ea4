#include "core/query/vdb_grid.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <sstream>
#include <string>
#include <utility>

#include <openvdb/io/Compression.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/io/io.h>

namespace steadymap {
namespace {

template <typename Number>
void WriteNumber(Number number, std::ostream* out) {
  out->write(reinterpret_cast<const char*>(&number), sizeof(number));
}

/// Returns the compression that OpenVDB selects for a grid of this class if zip is requested: none
/// for level sets.
std::uint32_t CompressionOf(const openvdb::GridBase& grid) {
  const bool zips = grid.getGridClass() != openvdb::GRID_LEVEL_SET;
  return openvdb::io::COMPRESS_ACTIVE_MASK |
         (zips ? openvdb::io::COMPRESS_ZIP : openvdb::io::COMPRESS_NONE);
}

/// Returns the box around the voxels of a leaf, from the words of its mask
/// (core/volume/voxel_leaf.h), which is fast enough for a million leaves.
openvdb::CoordBBox BoundsOf(const MaskedLeaf& leaf) {
  int low_x = kLeafSide;
  int high_x = 0;
  std::uint64_t rows = 0;  // Bit y * 8 + z.
  for (int x = 0; x < kLeafSide; ++x) {
    const std::uint64_t word = leaf.mask[static_cast<std::size_t>(x)];
    if (word == 0) continue;
    low_x = std::min(low_x, x);
    high_x = x;
    rows |= word;
  }
  std::uint8_t column = 0;  // Bit z.
  for (int y = 0; y < kLeafSide; ++y) column |= static_cast<std::uint8_t>(rows >> (y * kLeafSide));
  const openvdb::Coord origin = ToCoord(leaf.origin);
  return {origin.offsetBy(low_x, std::countr_zero(rows) / kLeafSide, std::countr_zero(column)),
          origin.offsetBy(high_x,
                          kLeafSide - 1 - std::countl_zero(rows) / kLeafSide,
                          kLeafSide - 1 - std::countl_zero(column))};
}

/// See `VdbGridWriter`. Uses the order of OpenVDB: descriptor, metadata and transform; the masks of
/// the nodes, each before its children; the values of the leaves.
template <typename Grid>
class StockGridWriter final : public VdbGridWriter {
 public:
  using Value = typename Grid::ValueType;

  StockGridWriter(typename Grid::Ptr description,
                  std::span<const MaskedLeaf> leaves,
                  VdbValueReader<Value> read_values)
      : grid_(std::move(description)),
        leaves_(leaves),
        read_values_(std::move(read_values)),
        background_(grid_->background()),
        compression_(CompressionOf(*grid_)) {}

  bool WriteNext(std::ostream* out) override {
    if (!head_written_) {
      head_written_ = true;
      WriteHead(out);
      return true;
    }
    if (next_node_ < leaves_.size()) {
      WriteNodes(next_node_++, out);
      return true;
    }
    if (next_values_ == leaves_.size()) return false;
    WriteValues(leaves_[next_values_++], out);
    return true;
  }

 private:
  using Tree = typename Grid::TreeType;
  using TopNode = typename Tree::RootNodeType::ChildNodeType;
  using MiddleNode = typename TopNode::ChildNodeType;
  using LeafNode = typename Tree::LeafNodeType;

  template <typename Node>
  static openvdb::Coord OriginOf(const MaskedLeaf& leaf) {
    const auto mask = static_cast<openvdb::Int32>(~(Node::DIM - 1));
    return {leaf.origin.x & mask, leaf.origin.y & mask, leaf.origin.z & mask};
  }

  /// True if the leaf at `place` is the first in its node of this type.
  template <typename Node>
  bool IsFirstOf(std::size_t place) const {
    return place == 0 || OriginOf<Node>(leaves_[place - 1]) != OriginOf<Node>(leaves_[place]);
  }

  template <typename Node>
  std::size_t CountNodes() const {
    std::size_t count = 0;
    for (std::size_t i = 0; i < leaves_.size(); ++i) count += IsFirstOf<Node>(i) ? 1 : 0;
    return count;
  }

  void WriteHead(std::ostream* out) {
    const openvdb::io::GridDescriptor descriptor(grid_->getName(), grid_->type());
    descriptor.writeHeader(*out);
    descriptor.writeStreamPos(*out);  // Zeros: a stream has no offsets.
    openvdb::io::setDataCompression(*out, compression_);
    openvdb::io::setGridBackgroundValuePtr(*out, &background_);
    WriteNumber(compression_, out);
    AddStatistics();
    grid_->writeMeta(*out);
    grid_->writeTransform(*out);
    constexpr std::int32_t kBuffers = 1;
    WriteNumber(kBuffers, out);
    WriteNumber(background_, out);
    WriteNumber(std::uint32_t{0}, out);  // Tiles of the root.
    WriteNumber(static_cast<std::uint32_t>(CountNodes<TopNode>()), out);
    PrepareTiles();
  }

  /// Adds the metadata that OpenVDB adds to every grid it writes.
  void AddStatistics() {
    openvdb::CoordBBox bounds;
    std::uint64_t voxels = 0;
    for (const MaskedLeaf& leaf : leaves_) {
      voxels += CountBits(leaf.mask);
      bounds.expand(BoundsOf(leaf));
    }
    const std::size_t bytes = sizeof(Tree) + sizeof(typename Tree::RootNodeType) +
                              CountNodes<TopNode>() * InnerNodeBytes<TopNode>() +
                              CountNodes<MiddleNode>() * InnerNodeBytes<MiddleNode>() +
                              leaves_.size() * (sizeof(LeafNode) + LeafNode::SIZE * sizeof(Value));
    using openvdb::GridBase;
    const auto number = [](std::uint64_t value) {
      return openvdb::Int64Metadata(static_cast<std::int64_t>(value));
    };
    grid_->insertMeta(GridBase::META_FILE_BBOX_MIN, openvdb::Vec3IMetadata(bounds.min().asVec3i()));
    grid_->insertMeta(GridBase::META_FILE_BBOX_MAX, openvdb::Vec3IMetadata(bounds.max().asVec3i()));
    grid_->insertMeta(GridBase::META_FILE_MEM_BYTES, number(bytes));
    grid_->insertMeta(GridBase::META_FILE_VOXEL_COUNT, number(voxels));
    grid_->insertMeta(GridBase::META_FILE_COMPRESSION,
                      openvdb::StringMetadata(openvdb::io::compressionToString(compression_)));
  }

  /// Returns the memory of an inner node in a built tree, bytes.
  template <typename Node>
  static std::size_t InnerNodeBytes() {
    return Node::NUM_VALUES * sizeof(typename Node::UnionType) +
           2 * sizeof(typename Node::NodeMaskType) + sizeof(openvdb::Coord);
  }

  /// Encodes the values of an inner node with OpenVDB: no value is active, all equal the
  /// background. The encoding is independent of their number, and equal for all inner nodes of
  /// these grids.
  void PrepareTiles() {
    std::ostringstream out(std::ios::binary);
    openvdb::io::setDataCompression(out, compression_);
    openvdb::io::setGridBackgroundValuePtr(out, &background_);
    values_.fill(background_);
    const LeafNodeMask none;
    openvdb::io::writeCompressedValues(out, values_.data(), LeafNode::SIZE, none, none, false);
    tiles_ = std::move(out).str();
  }

  /// Writes the mask of the leaf at `place`, preceded by the inner nodes that start with it.
  void WriteNodes(std::size_t place, std::ostream* out) {
    const MaskedLeaf& leaf = leaves_[place];
    if (IsFirstOf<TopNode>(place)) {
      const openvdb::Coord origin = OriginOf<TopNode>(leaf);
      out->write(reinterpret_cast<const char*>(origin.asPointer()), sizeof(openvdb::Coord));
      WriteInnerNode<TopNode>(place, out);
    }
    if (IsFirstOf<MiddleNode>(place)) WriteInnerNode<MiddleNode>(place, out);
    ToNodeMask(leaf.mask).save(*out);
  }

  /// Writes the inner node whose first leaf is at `first`.
  template <typename Node>
  void WriteInnerNode(std::size_t first, std::ostream* out) const {
    typename Node::NodeMaskType children;
    for (std::size_t i = first; i < leaves_.size(); ++i) {
      if (i > first && IsFirstOf<Node>(i)) break;
      const LeafOrigin& leaf = leaves_[i].origin;
      children.setOn(Node::coordToOffset({leaf.x, leaf.y, leaf.z}));
    }
    children.save(*out);
    const typename Node::NodeMaskType active_tiles;
    active_tiles.save(*out);
    out->write(tiles_.data(), static_cast<std::streamsize>(tiles_.size()));
  }

  void WriteValues(const MaskedLeaf& leaf, std::ostream* out) {
    const LeafNodeMask mask = ToNodeMask(leaf.mask);
    mask.save(*out);
    values_.fill(background_);
    read_values_(leaf, values_.data());
    const LeafNodeMask no_children;
    openvdb::io::writeCompressedValues(
        *out, values_.data(), LeafNode::SIZE, mask, no_children, /*toHalf=*/false);
  }

  const typename Grid::Ptr grid_;
  const std::span<const MaskedLeaf> leaves_;
  const VdbValueReader<Value> read_values_;
  const Value background_;
  const std::uint32_t compression_;
  std::string tiles_;  ///< The encoded values of an inner node.
  std::array<Value, LeafNode::SIZE> values_;
  bool head_written_ = false;
  std::size_t next_node_ = 0;    ///< Index of the leaf with the next mask.
  std::size_t next_values_ = 0;  ///< Index of the leaf with the next values.
};

}  // namespace

std::unique_ptr<VdbGridWriter> MakeVdbGridWriter(openvdb::FloatGrid::Ptr description,
                                                 std::span<const MaskedLeaf> leaves,
                                                 VdbValueReader<float> read_values) {
  return std::make_unique<StockGridWriter<openvdb::FloatGrid>>(
      std::move(description), leaves, std::move(read_values));
}

std::unique_ptr<VdbGridWriter> MakeVdbGridWriter(openvdb::Vec3fGrid::Ptr description,
                                                 std::span<const MaskedLeaf> leaves,
                                                 VdbValueReader<openvdb::Vec3f> read_values) {
  return std::make_unique<StockGridWriter<openvdb::Vec3fGrid>>(
      std::move(description), leaves, std::move(read_values));
}

}  // namespace steadymap
