#pragma once

#include <span>

#include "core/geometry/geometry.h"
#include "core/map/placed_volume.h"
#include "core/types/cancellation.h"
#include "core/volume/mesh.h"
#include "core/volume/voxel_leaf.h"

namespace steadymap {

/// Extracts the surfaces of several volumes as one mesh in the world frame: the results of
/// `ExtractMesh`, in the order of the volumes. If any volume has colours, vertices of volumes
/// without colours are mid-grey.
///
/// `box_world`, if not null, selects the cells whose vertex is in the box. Cost: that of
/// `ExtractMesh` for each volume whose surface may reach the box. After cancellation the mesh is
/// incomplete or empty.
Mesh ExtractMapMesh(std::span<const PlacedVolume> volumes,
                    const VoxelScale& scale,
                    const Box* box_world,
                    const Cancellation& cancellation = {});

}  // namespace steadymap
