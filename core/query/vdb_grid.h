#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <ostream>
#include <span>

#include "core/query/vdb_leaves.h"
#include "core/volume/tsdf_trees.h"

/// Private to the vdb files: single grids.
namespace steadymap {

/// Maximum length of one `VdbGridWriter::WriteNext`: the masks of a few inner nodes, or the colours
/// of a leaf.
inline constexpr std::size_t kMaxVdbPartBytes = std::size_t{16} << 10;

/// Writes one grid of an OpenVDB file in parts. The bytes equal those of `openvdb::io::Stream`,
/// except for the metadata `file_delayed_load`, which is omitted. It contains the length of every
/// leaf, requires a second compression of each, and is only useful in files with random access.
///
/// The tree is written from the list of its leaves and never built. The inner nodes of a stock tree
/// take 300 KB, and eight times as much if a volume has voxels on both sides of its origin, while
/// the leaves of most objects take a tenth of that. In the file an inner node is two masks.
class VdbGridWriter {
 public:
  virtual ~VdbGridWriter() = default;

  /// Writes the next part. Returns false without output if the grid is complete.
  virtual bool WriteNext(std::ostream* out) = 0;
};

/// Reads the values of a leaf: sets those in its mask in an array of 512, and leaves the others
/// unchanged.
template <typename Value>
using VdbValueReader = std::function<void(const MaskedLeaf& leaf, Value* values)>;

/// Returns a writer of a grid with the name, metadata, transform and background of the empty grid
/// `description` and the active voxels in `leaves`, which must be in tree order and outlive the
/// writer.
std::unique_ptr<VdbGridWriter> MakeVdbGridWriter(openvdb::FloatGrid::Ptr description,
                                                 std::span<const MaskedLeaf> leaves,
                                                 VdbValueReader<float> read_values);
std::unique_ptr<VdbGridWriter> MakeVdbGridWriter(openvdb::Vec3fGrid::Ptr description,
                                                 std::span<const MaskedLeaf> leaves,
                                                 VdbValueReader<openvdb::Vec3f> read_values);

}  // namespace steadymap
