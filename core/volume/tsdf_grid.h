#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "core/volume/voxel_leaf.h"

namespace steadymap {

/// Reads the leaves of something that has voxels: one grid, or the background with its tiles.
/// Sampling, ray casting and meshing work on any of them.
class VoxelReader {
 public:
  virtual ~VoxelReader() = default;

  /// The leaf at `origin`; null where nothing was observed.
  virtual LeafView FindLeaf(LeafOrigin origin) const = 0;

  /// Calls `visit` for one leaf after the other until it returns false; in an order that depends on
  /// nothing but the leaves present. Whether all were visited.
  virtual bool VisitLeaves(const std::function<bool(LeafOrigin, const LeafView&)>& visit) const = 0;

  /// Calls `visit` for every leaf, in the same order.
  void ForEachLeaf(const std::function<void(LeafOrigin, const LeafView&)>& visit) const;

  virtual std::size_t leaf_count() const = 0;

  /// Side, in voxels, of an empty cube around the leaf at `origin`, which must not exist: a power
  /// of two, at least `kLeafSide`. The cube's lowest voxel is a multiple of its side. The larger it
  /// is, the further a ray may go at once; here no larger than the leaf.
  virtual int EmptySideAt(LeafOrigin origin) const;
};

/// One volume: an OpenVDB tree of distances and one of weights with the same leaves, and where
/// colour was recorded one of colours.
///
/// The trees branch 8-8-8 instead of OpenVDB's default 32-16-8: an empty pair costs 20 KB instead
/// of 600 KB, which matters when every object has one (targets.md). Files hold stock FloatGrids.
///
/// Not thread-safe while it is written; any number of threads may read it otherwise.
class TsdfGrid final : public VoxelReader {
 public:
  TsdfGrid();
  ~TsdfGrid() override;
  TsdfGrid(TsdfGrid&&) noexcept;
  TsdfGrid& operator=(TsdfGrid&&) noexcept;

  /// A deep copy. Cost: about 0.4 us a leaf.
  std::unique_ptr<TsdfGrid> Clone() const;

  LeafView FindLeaf(LeafOrigin origin) const override;
  bool VisitLeaves(const std::function<bool(LeafOrigin, const LeafView&)>& visit) const override;
  std::size_t leaf_count() const override;

  /// A leaf, or the largest node of the tree that is not there: 64 or 512 voxels.
  int EmptySideAt(LeafOrigin origin) const override;

  /// Write access to the leaf at `origin`; null where there is none. `with_color` adds colours
  /// where the leaf has none yet. Call `SetObserved` with the union of old and new voxels
  /// afterwards.
  LeafEdit EditLeaf(LeafOrigin origin, bool with_color);

  /// Says which voxels of an existing leaf are observed.
  void SetObserved(LeafOrigin origin, const LeafMask& observed);

  /// Replaces the leaf at `origin`; one without observed voxels removes it.
  void StoreLeaf(LeafOrigin origin, const LeafVoxels& voxels);

  /// Copies the leaf at `origin` to `voxels`; zeros where there is none.
  void LoadLeaf(LeafOrigin origin, LeafVoxels* voxels) const;

  /// Observed voxels. Cost: one pass over the leaves' masks.
  std::size_t CountObservedVoxels() const;

  /// Bytes of the trees, nodes and leaves.
  std::size_t memory_bytes() const;

 private:
  struct Trees;
  std::unique_ptr<Trees> trees_;
};

}  // namespace steadymap
