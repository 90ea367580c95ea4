#pragma once

#include <vector>

#include "core/volume/tsdf_grid.h"
#include "core/working/object_edit.h"
#include "core/working/tracked_object.h"

/// Edits of objects, in a map or outside of it.
namespace steadymap::testing {

/// Replaces the volume of an object by a copy of `volume`.
inline void StoreVolume(const TsdfGrid& volume, ObjectEdit* edit) {
  std::vector<LeafOrigin> removed;
  edit->object().volume().ForEachLeaf([&](LeafOrigin origin, const LeafView&) {
    if (!volume.FindLeaf(origin)) removed.push_back(origin);
  });
  for (const LeafOrigin& origin : removed) edit->StoreLeaf(origin, LeafVoxels{});
  volume.ForEachLeaf([&](LeafOrigin origin, const LeafView&) {
    LeafVoxels voxels;
    volume.LoadLeaf(origin, &voxels);
    edit->StoreLeaf(origin, voxels);
  });
}

/// The same for an object that is not part of a map.
inline void StoreVolume(const TsdfGrid& volume, TrackedObject* object) {
  ObjectEdit edit = ObjectEdit::OfUnregistered(object);
  StoreVolume(volume, &edit);
}

/// Returns write access to the state of an object that is not part of a map.
inline ObjectState& StateOf(TrackedObject* object) {
  ObjectEdit edit = ObjectEdit::OfUnregistered(object);
  return edit.state();
}

}  // namespace steadymap::testing
