#pragma once

#include "core/geometry/geometry.h"
#include "core/types/cancellation.h"
#include "core/volume/mesh.h"
#include "core/volume/tsdf_grid.h"
#include "core/volume/voxel_leaf.h"

namespace steadymap {

/// The zero surface of a volume, as triangles in the volume's frame.
///
/// One vertex a cell of 2 x 2 x 2 voxels that the surface crosses, at the mean of its crossings
/// (surface nets: Gibson 1998, "Constrained Elastic Surface Nets"), two triangles an edge between
/// voxels of opposite sign. Cells with an unobserved voxel have no surface, so the back of a
/// truncation band never shows; nor has it any where the distance jumps (`kMaxSurfaceSlope`).
/// Colours are given if any voxel of the volume has one; vertices without a coloured voxel near are
/// then mid-grey.
///
/// `box`, where given, keeps the cells whose vertex lies within it. The result depends on the
/// volume's voxels alone. Cost: about 10 us a leaf with surface. Ends early once `cancellation`
/// says so; the mesh is then of no use.
Mesh ExtractMesh(const VoxelReader& reader,
                 const VoxelScale& scale,
                 const Box* box,
                 const Cancellation& cancellation = {});

}  // namespace steadymap
