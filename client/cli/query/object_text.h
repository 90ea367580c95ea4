#pragma once

#include <cstdint>
#include <map>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include <absl/status/statusor.h>

#include "client/cli/text/json_writer.h"
#include "client/map/map_client.h"
#include "core/types/identifiers.h"

#include "google/protobuf/timestamp.pb.h"
#include "steadymap/v1/event.pb.h"
#include "steadymap/v1/map.pb.h"
#include "steadymap/v1/object.pb.h"

/// Objects and their history, for people and for programs.
namespace steadymap {

/// What the classes of a map are called.
class ClassNames {
 public:
  explicit ClassNames(const v1::MapConfig& config);

  /// The class's name; `class 12` for one that the table lacks.
  std::string NameOf(std::uint32_t class_id) const;

  /// A class by its name or its id. Errors: `InvalidArgument` for one that the map does not have.
  absl::StatusOr<ClassId> Parse(const std::string& text) const;

  /// Several of them, in their order. Errors: the first one's.
  absl::StatusOr<std::vector<ClassId>> ParseAll(const std::vector<std::string>& texts) const;

 private:
  std::map<std::uint32_t, std::string> names_;
};

/// The type of an event by its name. Errors: `InvalidArgument` that lists the types.
absl::StatusOr<v1::EventType> ParseEventType(std::string_view text);

/// A line an object, under a line of headings.
void WriteObjectTable(const std::vector<v1::Object>& objects,
                      const ClassNames& classes,
                      std::ostream* out);

/// An object in one line, without a line feed.
std::string ObjectText(const v1::Object& object, const ClassNames& classes);

/// Seconds since 1970.
double SecondsOf(const google::protobuf::Timestamp& moment);

/// What a list call gave, as JSON: `{"revision", "<key>": [...]}`, each entry as `write_entry`
/// does.
template <typename Message>
std::string ListJson(const MapList<Message>& list,
                     std::string_view key,
                     const ClassNames& classes,
                     void (*write_entry)(const Message&, const ClassNames&, JsonWriter*)) {
  JsonWriter json;
  json.BeginObject().Key("revision").Integer(list.revision.value()).Key(key).BeginArray();
  for (const Message& entry : list.entries) write_entry(entry, classes, &json);
  json.EndArray().EndObject();
  return json.Finish();
}

/// An object as JSON: lengths in metres in the world frame, angles in radians, times in seconds
/// since 1970.
void WriteObjectJson(const v1::Object& object, const ClassNames& classes, JsonWriter* json);

/// A line an event.
void WriteEventLines(const std::vector<v1::ObjectEvent>& events,
                     const ClassNames& classes,
                     std::ostream* out);

/// An event as JSON, units as for objects.
void WriteEventJson(const v1::ObjectEvent& event, const ClassNames& classes, JsonWriter* json);

}  // namespace steadymap
