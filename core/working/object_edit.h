#pragma once

#include <span>
#include <vector>

#include "core/map/map_object.h"
#include "core/volume/voxel_leaf.h"
#include "core/working/tracked_object.h"

namespace steadymap {

class WorkingMap;

/// Write access to one object of a working map; made by `WorkingMap::Edit`. Its destructor updates
/// the surface, and marks the object as changed if the edit gave out the state or changed the
/// volume. Objects have no other write access, so that a commit cannot miss a change, and an object
/// without a change is not part of the delta.
///
/// Index and status sets of the map have the old values until the destructor. An edit therefore
/// ends before the code that finds objects by place or status. It must not outlive the frame.
class ObjectEdit {
 public:
  /// Makes an edit of an object that is not part of a map: there is nothing to mark.
  static ObjectEdit OfUnregistered(TrackedObject* object) { return {object, nullptr}; }

  ObjectEdit(const ObjectEdit&) = delete;
  ObjectEdit& operator=(const ObjectEdit&) = delete;
  ~ObjectEdit();

  const TrackedObject& object() const { return *object_; }

  /// Returns the state for writing. Not for temporaries, since the object is marked before a write
  /// to their state. To read, call `object().state()`, which marks nothing.
  ObjectState& state() & {
    is_changed_ = true;
    return object_->state_;
  }

  /// Replaces one leaf of the volume. If `voxels` has no observed voxel, removes the leaf.
  void StoreLeaf(LeafOrigin origin, const LeafVoxels& voxels);

  /// Replaces pose and volume by copies of those of another object.
  void TakeVolume(const TrackedObject& other);

 private:
  friend class WorkingMap;

  ObjectEdit(TrackedObject* object, WorkingMap* map) : object_(object), map_(map) {}

  /// Marks leaves of the volume that were written.
  void MarkLeaves(std::span<const LeafOrigin> leaves);

  TrackedObject* object_;
  WorkingMap* map_;  ///< Null for an object that is not part of a map.
  bool is_changed_ = false;
  std::vector<LeafOrigin> changed_leaves_;  ///< Those whose surface is not up to date.
};

}  // namespace steadymap
