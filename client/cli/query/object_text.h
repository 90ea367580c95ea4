#pragma once

#include <cstdint>
#include <map>
#include <ostream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <absl/status/statusor.h>

#include "client/cli/text/json_text.h"
#include "client/map/map_client.h"
#include "core/types/identifiers.h"

#include "google/protobuf/timestamp.pb.h"
#include "steadymap/v1/event.pb.h"
#include "steadymap/v1/geometry.pb.h"
#include "steadymap/v1/map.pb.h"
#include "steadymap/v1/object.pb.h"

/// Objects and their history as text and as JSON.
namespace steadymap {

/// The names of a map's classes.
class ClassNames {
 public:
  explicit ClassNames(const v1::MapConfig& config);

  /// Returns the name of a class; `class 12` for a class that is not in the table.
  std::string NameOf(std::uint32_t class_id) const;

  /// Returns a class by its name or its id. Errors: `InvalidArgument` for a class that the map does
  /// not have.
  absl::StatusOr<ClassId> Parse(const std::string& text) const;

  /// Parses several classes, in order. Returns the first error.
  absl::StatusOr<std::vector<ClassId>> ParseAll(const std::vector<std::string>& texts) const;

 private:
  std::map<std::uint32_t, std::string> names_;
};

/// Returns the type of an event by its name. Errors: `InvalidArgument` with the list of types in
/// the message.
absl::StatusOr<v1::EventType> ParseEventType(std::string_view text);

/// Writes a table with one line for each object.
void WriteObjectTable(const std::vector<v1::Object>& objects,
                      const ClassNames& classes,
                      std::ostream* out);

/// Returns an object as one line, without a line feed.
std::string ObjectText(const v1::Object& object, const ClassNames& classes);

/// Returns a point as an array of its coordinates.
Json PointJson(const v1::Vector3& point);

/// Converts a time to seconds since 1970.
double SecondsOf(const google::protobuf::Timestamp& moment);

/// Returns the result of a list call as JSON: `{"revision", "<key>": [...]}`. `entry_json` converts
/// each entry.
template <typename Message>
Json ListJson(const MapList<Message>& list,
              std::string_view key,
              const ClassNames& classes,
              Json (*entry_json)(const Message&, const ClassNames&)) {
  Json entries = Json::array();
  for (const Message& entry : list.entries) entries.push_back(entry_json(entry, classes));
  return {{"revision", list.revision.value()}, {key, std::move(entries)}};
}

/// Returns an object as JSON: lengths in metres in the world frame, angles in radians, times in
/// seconds since 1970.
Json ObjectJson(const v1::Object& object, const ClassNames& classes);

/// Writes one line for each event.
void WriteEventLines(const std::vector<v1::ObjectEvent>& events,
                     const ClassNames& classes,
                     std::ostream* out);

/// Returns an event as JSON, in the units of `ObjectJson`.
Json EventJson(const v1::ObjectEvent& event, const ClassNames& classes);

}  // namespace steadymap
