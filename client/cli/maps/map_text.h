#pragma once

#include <ostream>
#include <string_view>
#include <vector>

#include "client/cli/text/json_text.h"

#include "steadymap/v1/map.pb.h"

namespace steadymap {

/// Writes all properties of a map as readable text, one line for each.
void WriteMapText(const v1::Map& map, std::ostream* out);

/// Writes a readable table with one line for each map. A line with the labels and a line with the
/// world frame follow, where the map has them.
void WriteMapTable(const std::vector<v1::Map>& maps, std::ostream* out);

/// Returns all properties of a map as a JSON object, with the field names of map.proto and counts
/// as numbers.
Json MapJson(const v1::Map& map);

/// Writes the result of a change to a map: `done` and the map's name, such as "created
/// tenants/t/maps/m", or the map as `MapJson`.
void WriteChangedMap(std::string_view done, const v1::Map& map, bool as_json, std::ostream* out);

}  // namespace steadymap
