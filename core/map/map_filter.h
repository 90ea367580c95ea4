#pragma once

#include <set>
#include <vector>

#include "core/geometry/geometry.h"
#include "core/map/map_object.h"
#include "core/map/object_event.h"
#include "core/types/identifiers.h"
#include "core/volume/voxel_leaf.h"

namespace steadymap {

/// A filter for watchers of a map. Combines all its conditions. An object passes as a whole, with
/// all its leaves. The background counts as object 0 of class 0; its leaves pass one by one if they
/// touch a box.
struct MapFilter {
  std::vector<Box> boxes_world;  ///< Metres, world frame. Empty: everywhere.
  std::set<ClassId> classes;     ///< Empty: all classes.
  std::set<ObjectId> objects;    ///< Empty: all objects.
  bool events = true;            ///< Events of objects and robots.
  bool states = true;            ///< States of objects.
  bool volumes = true;           ///< Leaves, with the states of their objects.
  bool archived = false;         ///< Archived objects as well as present ones.

  /// True if states of objects are required, on their own or for their leaves.
  bool WantsObjects() const { return states || volumes; }

  /// True if an object passes. A tentative object never passes.
  bool Shows(const ObjectState& object) const;

  /// `ShowsBackground`: true if parts of the background can pass. `ShowsBackgroundLeaf`: true if
  /// this leaf of the background passes.
  bool ShowsBackground() const;
  bool ShowsBackgroundLeaf(LeafOrigin origin, const VoxelScale& scale) const;

  /// True if an event passes, by its object, its related object, its class and its position. An
  /// event of a robot passes unless the filter has boxes, classes or objects.
  bool Shows(const ObjectEvent& event) const;
};

}  // namespace steadymap
