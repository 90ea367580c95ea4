#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "core/volume/voxel_leaf.h"

namespace steadymap {

/// Read access to the leaves of a volume: a single grid, or all tiles of the background. Input of
/// sampling, ray casting and meshing.
class VoxelReader {
 public:
  virtual ~VoxelReader() = default;

  /// Returns the leaf at `origin`; null if the leaf does not exist.
  virtual LeafView FindLeaf(LeafOrigin origin) const = 0;

  /// Calls `visit` for each leaf until it returns false, in an order that depends only on the set
  /// of leaves. Returns true if all leaves were visited.
  virtual bool VisitLeaves(const std::function<bool(LeafOrigin, const LeafView&)>& visit) const = 0;

  /// Calls `visit` for each leaf, in the order of `VisitLeaves`.
  void ForEachLeaf(const std::function<void(LeafOrigin, const LeafView&)>& visit) const;

  virtual std::size_t leaf_count() const = 0;

  /// Returns the side, in voxels, of an empty cube around the leaf at `origin`, which must not
  /// exist. The side is a power of two, at least `kLeafSide`; the coordinates of the cube's lowest
  /// voxel are multiples of it. Ray casting skips the cube. The default implementation returns
  /// `kLeafSide`.
  virtual int EmptySideAt(LeafOrigin origin) const;
};

/// A volume: an OpenVDB tree of voxels, of 32 bits each, and a tree of colours with the leaves
/// whose colour is known.
///
/// The trees have one level of inner nodes, of 8 x 8 x 8 leaves, instead of OpenVDB's two of 32 and
/// 16 per side. A tree of one leaf takes 7 KB instead of 300 KB, which matters with one per object.
/// Files contain stock FloatGrids.
///
/// Not thread-safe during writes. Otherwise, any number of threads may read.
class TsdfGrid final : public VoxelReader {
 public:
  TsdfGrid();
  ~TsdfGrid() override;
  TsdfGrid(TsdfGrid&&) noexcept;
  TsdfGrid& operator=(TsdfGrid&&) noexcept;

  /// Returns a deep copy. Cost: about 0.4 us per leaf.
  std::unique_ptr<TsdfGrid> Clone() const;

  LeafView FindLeaf(LeafOrigin origin) const override;
  bool VisitLeaves(const std::function<bool(LeafOrigin, const LeafView&)>& visit) const override;
  std::size_t leaf_count() const override;

  /// Returns the side of the leaf, or of the inner node around it if that is missing: 64 voxels.
  int EmptySideAt(LeafOrigin origin) const override;

  /// Returns write access to the leaf at `origin`; null if it does not exist. `with_color` adds the
  /// colours if the leaf has none. After the edit, call `SetObserved` with the union of old and new
  /// voxels.
  LeafEdit EditLeaf(LeafOrigin origin, bool with_color);

  /// Sets the observed voxels of an existing leaf.
  void SetObserved(LeafOrigin origin, const LeafMask& observed);

  /// Replaces the leaf at `origin`. If `voxels` has no observed voxel, removes the leaf.
  void StoreLeaf(LeafOrigin origin, const LeafVoxels& voxels);

  /// Copies the leaf at `origin` to `voxels`; zeros if it does not exist.
  void LoadLeaf(LeafOrigin origin, LeafVoxels* voxels) const;

  /// Returns the number of observed voxels. Cost: one pass over the masks of the leaves.
  std::size_t CountObservedVoxels() const;

  /// Returns the memory of the trees, bytes: nodes and leaves.
  std::size_t memory_bytes() const;

 private:
  struct Trees;
  std::unique_ptr<Trees> trees_;
};

}  // namespace steadymap
