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

/// The most that `VdbGridWriter::WriteNext` writes: a few inner nodes' masks, or a leaf's colours.
inline constexpr std::size_t kMaxVdbPartBytes = std::size_t{16} << 10;

/// Writes one grid of an OpenVDB file part by part, byte for byte as `openvdb::io::Stream` does but
/// for one piece of metadata, `file_delayed_load`: it holds the length of every leaf, for which
/// each is compressed twice, and serves files that can be read in part, which a stream cannot.
///
/// The tree is written from the list of its leaves and never built: the inner nodes of a stock tree
/// take 300 KB, and where a volume has voxels on both sides of its origin eight times as much,
/// while the leaves of most objects take a tenth of that. In the file an inner node is two masks.
class VdbGridWriter {
 public:
  virtual ~VdbGridWriter() = default;

  /// Writes the next part; false, and nothing is written, once the grid is whole.
  virtual bool WriteNext(std::ostream* out) = 0;
};

/// Gives the values of a leaf: sets those in its mask of 512, and leaves the others as they are.
template <typename Value>
using VdbValueReader = std::function<void(const MaskedLeaf& leaf, Value* values)>;

/// A writer of the grid that has the name, metadata, transform and background of the empty grid
/// `description`, and active voxels in `leaves`, which are in tree order and outlive the writer.
std::unique_ptr<VdbGridWriter> MakeVdbGridWriter(openvdb::FloatGrid::Ptr description,
                                                 std::span<const MaskedLeaf> leaves,
                                                 VdbValueReader<float> read_values);
std::unique_ptr<VdbGridWriter> MakeVdbGridWriter(openvdb::Vec3fGrid::Ptr description,
                                                 std::span<const MaskedLeaf> leaves,
                                                 VdbValueReader<openvdb::Vec3f> read_values);

}  // namespace steadymap
