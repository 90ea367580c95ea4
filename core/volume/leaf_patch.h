#pragma once

#include <optional>

#include "core/volume/voxel_leaf.h"

/// The difference of two states of a leaf. A patch contains voxel states, not operations, so its
/// application is idempotent, also to a leaf that has some of the changes. A patch is a leaf with
/// the changed voxels only, and is packed in the same format.
namespace steadymap {

/// Returns the voxels of `after` that differ from `before`; valid as long as `after`. Returns none
/// if a patch cannot express the change: `before` or `after` is null, a voxel is no longer
/// observed, or the leaf lost its colours. Returns a patch without observed voxels if the leaves
/// are equal.
std::optional<LeafView> FindLeafPatch(const LeafView& before, const LeafView& after);

/// Overwrites the voxels of the patch in `leaf` and keeps all others.
void ApplyLeafPatch(const LeafVoxels& patch, LeafVoxels* leaf);

}  // namespace steadymap
