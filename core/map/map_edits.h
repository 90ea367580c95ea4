#pragma once

#include <map>
#include <memory>
#include <string_view>

#include <absl/status/status.h>

#include "core/map/map_object.h"
#include "core/map/map_snapshot.h"
#include "core/types/identifiers.h"
#include "core/volume/tsdf_grid.h"

namespace steadymap {

/// Writes new states into a snapshot, in any order and number. Data shared with other snapshots is
/// cloned once, before the first write, so the cost is proportional to the changes.
///
/// Changes of the background take effect immediately, changes of objects in `Finish`. After an
/// error the caller must discard the snapshot. The snapshot must outlive the edits, and no other
/// writer may access it meanwhile.
class MapEdits {
 public:
  explicit MapEdits(MapSnapshot* snapshot) : snapshot_(snapshot) {}

  /// Removes an object with its volume. No effect if it does not exist.
  void RemoveObject(ObjectId id);

  /// Sets the state of an object and keeps its volume. A new or removed object gets an empty
  /// volume. The id must be above 0 (asserted).
  void SetState(const ObjectState& state);

  /// Replaces a leaf. `packed` has the format of `tsdf_codec.h`; empty: removes the leaf. Errors:
  /// `DataLoss` for a corrupt leaf, or a leaf of an object that does not exist, unless it is empty.
  absl::Status StoreLeaf(const LeafKey& key, std::string_view packed);

  /// Replaces some voxels of a leaf. `packed` is a packed leaf with these voxels only
  /// (`leaf_patch.h`). Errors: `DataLoss` for a corrupt or empty patch, or a patch of a leaf that
  /// does not exist.
  absl::Status PatchLeaf(const LeafKey& key, std::string_view packed);

  /// Writes the changed objects to the snapshot. Call once, last.
  void Finish();

 private:
  struct ObjectEdit {
    std::shared_ptr<MapObject> object;
    std::shared_ptr<TsdfGrid> volume;  ///< Null until the first write.
  };

  /// Returns the edit of an object; null if the object does not exist.
  ObjectEdit* Edit(ObjectId id);

  /// Returns the volume of an object for writing; null if the object does not exist.
  TsdfGrid* MutableVolume(ObjectId id);

  /// Returns the grid that contains a leaf, for writing; null if the object does not exist.
  TsdfGrid* MutableGrid(const LeafKey& key);

  MapSnapshot* snapshot_;
  std::map<ObjectId, ObjectEdit> edits_;
};

}  // namespace steadymap
