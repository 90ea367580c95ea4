#pragma once

#include "core/map_snapshot.h"
#include "core/placed_volume.h"
#include "core/tsdf_trees.h"

/// Private to the vdb files: what a grid says of the volume that it is of.
namespace steadymap {

/// Names `grid` `<volume>/<kind>`, places it in the world and adds its metadata; see
/// core/vdb_file.h.
void DescribeGrid(const MapSnapshot& snapshot,
                  const PlacedVolume& volume,
                  const char* kind,
                  openvdb::GridBase* grid);

}  // namespace steadymap
