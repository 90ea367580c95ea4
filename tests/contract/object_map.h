#pragma once

#include <cstdint>
#include <vector>

#include "core/map/map_snapshot.h"
#include "core/map/object_event.h"
#include "tests/contract/test_service.h"

namespace steadymap {

/// The revision of `MakeObjectMap`.
inline constexpr std::uint64_t kObjectMapRevision = 7;

/// A floor and over it four boxes, a metre apart along x: 1 and 3 are present, 2 is archived, 4
/// tentative. Box `id` stands at x = id - 1.5 m, y = 0.5 m, z = 0.8 m, has class 100 + id, and was
/// changed by frame `id`.
MapSnapshot MakeObjectMap();

/// The five events that led there.
std::vector<ObjectEvent> MakeObjectHistory(const MapSnapshot& map);

/// A map of revision 7, too: a floor and `boxes` boxes that are present, some kilobytes each.
MapSnapshot MakeCrowdedMap(int boxes);

/// Puts a map of revision 7 and its history into the store as a mapper would have, for the only map
/// that the service has, and restarts the service.
void StoreMap(TestService* service, const MapSnapshot& map, const std::vector<ObjectEvent>& events);

/// The same with `MakeObjectMap` and `MakeObjectHistory`.
void StoreObjectMap(TestService* service);

}  // namespace steadymap
