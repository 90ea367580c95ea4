#pragma once

#include <map>
#include <vector>

#include "core/integration/tsdf_integrator.h"
#include "core/types/timestamp.h"
#include "core/volume/tsdf_grid.h"
#include "core/working/working_map.h"

namespace steadymap {

/// A second volume of the whole world beside a map's background: what the visit at hand has seen.
/// Kept in the map itself, in tentative objects that are tiles of it, so that it survives a
/// restart and costs what a frame touches. The map may hold no other objects.
///
/// Its frame is the world frame. One frame at a time: made anew for each.
class SessionVolume final : public VoxelReader {
 public:
  /// The layer as `map` holds it, which must outlive it.
  explicit SessionVolume(WorkingMap* map);

  LeafView FindLeaf(LeafOrigin origin) const override;
  bool VisitLeaves(const std::function<bool(LeafOrigin, const LeafView&)>& visit) const override;
  std::size_t leaf_count() const override;

  /// Whether nothing was ever fused into it.
  bool empty() const { return tiles_.empty(); }

  /// When a frame was last fused, to a second; the epoch if it is empty.
  Timestamp last_fused() const { return last_fused_; }

  /// Fuses the cells of the integrator's frame that belong to the background.
  void Fuse(TsdfIntegrator* integrator);

  /// Replaces one leaf.
  void StoreLeaf(LeafOrigin origin, const LeafVoxels& voxels);

  /// Forgets everything; a map forgets objects at the end of the frame.
  void Discard();

 private:
  /// Where a leaf of the world lies in the tile that holds it.
  struct Place {
    LeafOrigin tile;
    LeafOrigin origin;
  };

  static Place PlaceOf(LeafOrigin origin);
  TrackedObject* TileAt(LeafOrigin tile);
  void Stamp(TrackedObject* tile);

  WorkingMap& map_;
  std::map<LeafOrigin, TrackedObject*> tiles_;  ///< By lowest voxel.
  Timestamp last_fused_;
};

}  // namespace steadymap
