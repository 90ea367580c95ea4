#pragma once

#include <string>
#include <vector>

#include <openvdb/openvdb.h>

#include "core/map/map_snapshot.h"
#include "core/map/placed_volume.h"

namespace steadymap::testing {

/// What `WriteVdb` must give, written by OpenVDB itself: every grid is built as a stock tree, and
/// all are written at once by `openvdb::io::Stream`, with a UUID of zeros.
std::string WriteStockVdb(const MapSnapshot& snapshot,
                          const std::vector<PlacedVolume>& volumes,
                          const Box* box_world);

/// Any grids as such a file.
std::string WriteStockVdb(const openvdb::GridPtrVec& grids);

}  // namespace steadymap::testing
