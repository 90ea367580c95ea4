#pragma once

#include <ostream>
#include <string_view>
#include <vector>

#include "client/cli/text/json_writer.h"

#include "steadymap/v1/map.pb.h"

namespace steadymap {

/// Everything about a map, a line a fact, for people.
void WriteMapText(const v1::Map& map, std::ostream* out);

/// A line a map, under a line of headings, for people; below it a line with its labels and one with
/// its world frame, where it has any.
void WriteMapTable(const std::vector<v1::Map>& maps, std::ostream* out);

/// Everything about a map as a JSON object, fields spelt as in map.proto, counts as numbers.
void WriteMapJson(const v1::Map& map, JsonWriter* json);

/// The answer to a change of a map: `done` and its name, such as "created tenants/t/maps/m", or as
/// `WriteMapJson`.
void WriteChangedMap(std::string_view done, const v1::Map& map, bool as_json, std::ostream* out);

}  // namespace steadymap
