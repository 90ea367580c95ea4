#pragma once

#include <cstdint>
#include <vector>

#include "core/map/map_snapshot.h"
#include "core/map/object_event.h"
#include "tests/contract/test_service.h"

namespace steadymap {

/// Revision of `MakeObjectMap`.
inline constexpr std::uint64_t kObjectMapRevision = 7;

/// Returns a floor with four boxes above it, one metre apart along x: 1 and 3 are present, 2 is
/// archived, 4 tentative. Box `id` is at x = id - 1.5 m, y = 0.5 m, z = 0.8 m, has class 100 + id,
/// and was last changed by frame `id`.
MapSnapshot MakeObjectMap();

/// Returns the five events that led to `MakeObjectMap`.
std::vector<ObjectEvent> MakeObjectHistory(const MapSnapshot& map);

/// Returns a map of revision 7: a floor and `boxes` present boxes of some kilobytes each.
MapSnapshot MakeCrowdedMap(int boxes);

/// Stores a map of revision 7 and its history like a mapper, for the only map of the service, and
/// restarts the service.
void StoreMap(TestService* service, const MapSnapshot& map, const std::vector<ObjectEvent>& events);

/// Stores `MakeObjectMap` and `MakeObjectHistory`.
void StoreObjectMap(TestService* service);

}  // namespace steadymap
