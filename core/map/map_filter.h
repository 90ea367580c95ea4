#pragma once

#include <set>
#include <vector>

#include "core/geometry/geometry.h"
#include "core/map/map_object.h"
#include "core/map/object_event.h"
#include "core/types/identifiers.h"
#include "core/volume/voxel_leaf.h"

namespace steadymap {

/// What somebody who watches a map wants to see of it: what passes every filter that is set. An
/// object passes or not as a whole, with all its leaves. The background counts as object 0 of class
/// 0; of it, leaf by leaf, what touches a box.
struct MapFilter {
  std::vector<Box> boxes_world;  ///< Metres; empty: everywhere.
  std::set<ClassId> classes;     ///< Empty: of any class.
  std::set<ObjectId> objects;    ///< Empty: any object.
  bool events = true;            ///< What happened to objects and robots.
  bool states = true;            ///< States of objects.
  bool volumes = true;           ///< Leaves, and with them the states of objects.
  bool archived = false;         ///< Archived objects too, not only present ones.

  /// Whether states of objects are wanted, for their own sake or for their leaves'.
  bool WantsObjects() const { return states || volumes; }

  /// Whether an object passes. Tentative ones never do.
  bool Shows(const ObjectState& object) const;

  /// Whether any of the background passes, and whether this leaf of it does.
  bool ShowsBackground() const;
  bool ShowsBackgroundLeaf(LeafOrigin origin, const VoxelScale& scale) const;

  /// Whether an event passes, by its own object, the related one, or where it happened. Those of
  /// robots do where neither place nor class nor object is asked for.
  bool Shows(const ObjectEvent& event) const;
};

}  // namespace steadymap
