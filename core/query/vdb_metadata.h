#pragma once

#include "core/map/map_snapshot.h"
#include "core/map/placed_volume.h"
#include "core/volume/tsdf_trees.h"

/// Private to the vdb files: the metadata of a grid.
namespace steadymap {

/// Sets the name `<volume>/<kind>`, the transform and the metadata of `grid`; see
/// core/query/vdb_file.h.
void DescribeGrid(const MapSnapshot& snapshot,
                  const PlacedVolume& volume,
                  const char* kind,
                  openvdb::GridBase* grid);

}  // namespace steadymap
