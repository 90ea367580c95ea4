#pragma once

#include <string>
#include <vector>

#include <openvdb/openvdb.h>

#include "core/map/map_snapshot.h"
#include "core/map/placed_volume.h"

namespace steadymap::testing {

/// Returns the reference result for `WriteVdb`, written by OpenVDB itself: every grid is a stock
/// tree, and `openvdb::io::Stream` writes all grids at once, with a zero UUID.
std::string WriteStockVdb(const MapSnapshot& snapshot,
                          const std::vector<PlacedVolume>& volumes,
                          const Box* box_world);

/// Returns a file of the given grids, written in the same way.
std::string WriteStockVdb(const openvdb::GridPtrVec& grids);

}  // namespace steadymap::testing
