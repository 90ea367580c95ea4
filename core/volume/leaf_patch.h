#pragma once

#include <optional>

#include "core/volume/voxel_leaf.h"

/// What changes in a leaf between two looks at it: states of voxels, never operations, so that a
/// patch may be applied twice, or to a leaf that has some of it, without harm. A patch is a leaf
/// that holds the changed voxels alone, and packs like any other.
namespace steadymap {

/// The voxels of `after` that are not as in `before`; valid as long as `after`. None if nothing but
/// the whole leaf can tell: if there was none, or a voxel or all colours are gone. Without observed
/// voxels if the leaves are equal.
std::optional<LeafView> FindLeafPatch(const LeafView& before, const LeafView& after);

/// Writes the patch's voxels over those of `leaf`, which keeps the others.
void ApplyLeafPatch(const LeafVoxels& patch, LeafVoxels* leaf);

}  // namespace steadymap
