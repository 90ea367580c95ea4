#pragma once

#include <span>

#include "core/geometry/geometry.h"
#include "core/map/placed_volume.h"
#include "core/types/cancellation.h"
#include "core/volume/mesh.h"
#include "core/volume/voxel_leaf.h"

namespace steadymap {

/// The surface of several volumes, each where it stands, as one mesh in the world frame: volume by
/// volume in their order, each as `ExtractMesh` gives it. Vertices of volumes without colours are
/// mid-grey beside volumes that have some.
///
/// `box_world`, where given, keeps the cells whose vertex lies within it. Cost: as `ExtractMesh`,
/// for the volumes whose surface may reach into the box. Ends early once `cancellation` says so;
/// the mesh is then of no use.
Mesh ExtractMapMesh(std::span<const PlacedVolume> volumes,
                    const VoxelScale& scale,
                    const Box* box_world,
                    const Cancellation& cancellation = {});

}  // namespace steadymap
