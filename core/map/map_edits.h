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

/// Writes new states into a map, in any order and number. What other copies of the map share is
/// cloned before the first write, once, so the edits cost what they change.
///
/// The background is written at once, objects by `Finish`; whoever gives up before it must drop the
/// map. The map must outlive the edits and not be written by anyone else meanwhile.
class MapEdits {
 public:
  explicit MapEdits(MapSnapshot* snapshot) : snapshot_(snapshot) {}

  /// The object and its volume are gone; no harm if there is none.
  void RemoveObject(ObjectId id);

  /// A new state of an object, which keeps the volume that it has; one that is not there, or was
  /// removed, begins with an empty one. The id must be above 0 (asserted).
  void SetState(const ObjectState& state);

  /// A new leaf, packed as in `tsdf_codec.h`; empty: it is gone.
  /// Errors: `DataLoss` for a damaged leaf, or one of an object that is not there, unless it is
  /// empty.
  absl::Status StoreLeaf(const LeafKey& key, std::string_view packed);

  /// New voxels of a leaf that keeps its others, packed as a leaf of those alone (`leaf_patch.h`).
  /// Errors: `DataLoss` for a damaged patch, an empty one, or one of a leaf that is not there.
  absl::Status PatchLeaf(const LeafKey& key, std::string_view packed);

  /// Puts the objects into the map. To be called once, last.
  void Finish();

 private:
  struct ObjectEdit {
    std::shared_ptr<MapObject> object;
    std::shared_ptr<TsdfGrid> volume;  ///< Null as long as it is not written to.
  };

  /// Null if there is no such object.
  ObjectEdit* Edit(ObjectId id);

  /// The volume for writing; null if there is no such object.
  TsdfGrid* MutableVolume(ObjectId id);

  /// What holds a leaf, for writing; null if there is no such object.
  TsdfGrid* MutableGrid(const LeafKey& key);

  MapSnapshot* snapshot_;
  std::map<ObjectId, ObjectEdit> edits_;
};

}  // namespace steadymap
