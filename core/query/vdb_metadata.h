#pragma once

#include "core/map/map_snapshot.h"
#include "core/map/placed_volume.h"
#include "core/volume/tsdf_trees.h"

/// Private to the vdb files: what a grid says of the volume that it is of.
namespace steadymap {

/// Names `grid` `<volume>/<kind>`, places it in the world and adds its metadata; see
/// core/query/vdb_file.h.
void DescribeGrid(const MapSnapshot& snapshot,
                  const PlacedVolume& volume,
                  const char* kind,
                  openvdb::GridBase* grid);

}  // namespace steadymap
