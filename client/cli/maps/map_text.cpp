#include "client/cli/maps/map_text.h"

#include <algorithm>
#include <iomanip>
#include <map>
#include <string>

#include <absl/strings/str_join.h>

#include "client/cli/text/enumerator_text.h"
#include "client/cli/text/number_text.h"

namespace steadymap {
namespace {

// Servers that do not send a policy support only the static one.
std::string PolicyText(v1::UpdatePolicy policy) {
  return WordOf(v1::UpdatePolicy_descriptor(),
                policy == v1::UPDATE_POLICY_UNSPECIFIED ? v1::UPDATE_POLICY_STATIC : policy);
}

const char* MotionText(v1::ClassMotion motion) {
  switch (motion) {
    case v1::CLASS_MOTION_UNSPECIFIED:
    case v1::CLASS_MOTION_STATIC:
      return "static";
    case v1::CLASS_MOTION_SEMI_STATIC:
      return "semi-static";
    case v1::CLASS_MOTION_DYNAMIC:
      return "dynamic";
    default:
      return "unknown";
  }
}

// Returns the labels sorted by key.
std::map<std::string, std::string> LabelsOf(const v1::Map& map) {
  return {map.labels().begin(), map.labels().end()};
}

std::string LabelsText(const v1::Map& map) {
  return absl::StrJoin(LabelsOf(map), ", ", absl::PairFormatter("="));
}

std::string ConditionWord(const v1::MapState& state) {
  return WordOf(v1::MapCondition_descriptor(), state.condition());
}

std::string ConditionText(const v1::MapState& state) {
  const std::string& reason = state.condition_reason();
  return ConditionWord(state) + (reason.empty() ? "" : ": " + reason);
}

// `47.3700000, 8.5400000 degrees, 410.00 m above the ellipsoid, x points 90.00 degrees clockwise
// from north`.
std::string AnchorText(const v1::GeoAnchor& anchor) {
  return FixedText(anchor.latitude_deg(), 7) + ", " + FixedText(anchor.longitude_deg(), 7) +
         " degrees, " + FixedText(anchor.altitude_m(), 2) + " m above the ellipsoid, x points " +
         FixedText(anchor.heading_deg(), 2) + " degrees clockwise from north";
}

std::string WorldFrameText(const v1::WorldFrame& frame) {
  std::string text = frame.description();
  const auto append = [&text](const std::string& part) {
    text += (text.empty() ? "" : "; ") + part;
  };
  if (!frame.floor().empty()) append("floor " + frame.floor());
  if (frame.has_anchor()) append("origin at " + AnchorText(frame.anchor()));
  return text;
}

void WriteFact(const char* name, const std::string& value, std::ostream* out) {
  *out << std::left << std::setw(14) << name << value << '\n';
}

void WriteConfigJson(const v1::MapConfig& config, JsonWriter* json) {
  json->BeginObject();
  json->Key("voxel_size_m").Number(config.voxel_size_m());
  json->Key("truncation_m").Number(config.truncation_m());
  json->Key("max_depth_m").Number(config.max_depth_m());
  json->Key("policy").Text(PolicyText(config.policy()));
  json->Key("classes").BeginArray();
  for (const v1::SemanticClass& semantic_class : config.classes()) {
    json->BeginObject();
    json->Key("id").Integer(semantic_class.id());
    json->Key("name").Text(semantic_class.name());
    json->Key("motion").Text(MotionText(semantic_class.motion()));
    json->Key("in_background").Boolean(semantic_class.in_background());
    json->EndObject();
  }
  json->EndArray();
  json->EndObject();
}

void WriteWorldFrameJson(const v1::WorldFrame& frame, JsonWriter* json) {
  json->BeginObject();
  json->Key("description").Text(frame.description());
  json->Key("floor").Text(frame.floor());
  json->Key("anchor");
  if (frame.has_anchor()) {
    json->BeginObject();
    json->Key("latitude_deg").Number(frame.anchor().latitude_deg());
    json->Key("longitude_deg").Number(frame.anchor().longitude_deg());
    json->Key("altitude_m").Number(frame.anchor().altitude_m());
    json->Key("heading_deg").Number(frame.anchor().heading_deg());
    json->EndObject();
  } else {
    json->Null();
  }
  json->EndObject();
}

void WriteStateJson(const v1::MapState& state, JsonWriter* json) {
  json->BeginObject();
  json->Key("revision").Integer(state.revision());
  json->Key("durable_map_seq").Integer(state.durable_map_seq());
  json->Key("integrated_map_seq").Integer(state.integrated_map_seq());
  json->Key("lag_frames").Integer(state.lag_frames());
  json->Key("refused_frames").Integer(state.refused_frames());
  json->Key("present_objects").Integer(state.present_objects());
  json->Key("archived_objects").Integer(state.archived_objects());
  json->Key("leaves").Integer(state.leaves());
  json->Key("voxels").Integer(state.voxels());
  json->Key("memory_bytes").Integer(state.memory_bytes());
  json->Key("last_capture_time");
  if (state.has_last_capture_time()) {
    json->Text(TimeText(state.last_capture_time()));
  } else {
    json->Null();
  }
  json->Key("condition").Text(ConditionWord(state));
  json->Key("condition_reason").Text(state.condition_reason());
  json->EndObject();
}

}  // namespace

void WriteMapText(const v1::Map& map, std::ostream* out) {
  const v1::MapConfig& config = map.config();
  const v1::MapState& state = map.state();
  WriteFact("map", map.name(), out);
  if (!map.display_name().empty()) WriteFact("title", map.display_name(), out);
  WriteFact("condition", ConditionText(state), out);
  if (map.labels_size() > 0) WriteFact("labels", LabelsText(map), out);
  if (map.has_world_frame()) WriteFact("world frame", WorldFrameText(map.world_frame()), out);
  WriteFact("voxel size", LengthText(config.voxel_size_m()), out);
  WriteFact("truncation", LengthText(config.truncation_m()), out);
  WriteFact("max depth", LengthText(config.max_depth_m()), out);
  WriteFact("policy", PolicyText(config.policy()), out);
  WriteFact("classes", std::to_string(config.classes_size()), out);
  WriteFact("revision", std::to_string(state.revision()), out);
  WriteFact("log",
            CountText(state.integrated_map_seq()) + " entries integrated, " +
                CountText(state.lag_frames()) + " waiting, " + CountText(state.refused_frames()) +
                " frames refused since the start",
            out);
  WriteFact("objects",
            CountText(state.present_objects()) + " present, " +
                CountText(state.archived_objects()) + " archived",
            out);
  WriteFact("volume",
            CountText(state.voxels()) + " voxels in " + CountText(state.leaves()) + " leaves, " +
                BytesText(state.memory_bytes()) + " in memory",
            out);
  WriteFact("last capture",
            state.has_last_capture_time() ? TimeText(state.last_capture_time()) : "never",
            out);
  WriteFact("created", TimeText(map.create_time()), out);
}

void WriteMapTable(const std::vector<v1::Map>& maps, std::ostream* out) {
  std::size_t width = 4;
  for (const v1::Map& map : maps) width = std::max(width, map.name().size());
  const int name_width = static_cast<int>(width);
  *out << std::left << std::setw(name_width) << "NAME" << std::right << std::setw(10) << "VOXEL"
       << std::setw(10) << "REVISION" << std::setw(9) << "WAITING" << std::setw(12) << "VOXELS"
       << std::setw(12) << "MEMORY"
       << "  CONDITION\n";
  for (const v1::Map& map : maps) {
    *out << std::left << std::setw(name_width) << map.name() << std::right << std::setw(10)
         << LengthText(map.config().voxel_size_m()) << std::setw(10) << map.state().revision()
         << std::setw(9) << map.state().lag_frames() << std::setw(12) << map.state().voxels()
         << std::setw(12) << BytesText(map.state().memory_bytes()) << "  "
         << ConditionText(map.state()) << '\n';
    if (map.labels_size() > 0) *out << "  labels: " << LabelsText(map) << '\n';
    if (map.has_world_frame()) {
      *out << "  world frame: " << WorldFrameText(map.world_frame()) << '\n';
    }
  }
}

void WriteMapJson(const v1::Map& map, JsonWriter* json) {
  json->BeginObject();
  json->Key("name").Text(map.name());
  json->Key("display_name").Text(map.display_name());
  json->Key("create_time").Text(TimeText(map.create_time()));
  json->Key("etag").Text(map.etag());
  json->Key("incarnation").Text(map.incarnation());
  json->Key("byte_budget").Integer(map.byte_budget());
  json->Key("max_commit_delay_ms")
      .Integer(static_cast<std::uint64_t>(map.max_commit_delay().seconds() * 1000 +
                                          map.max_commit_delay().nanos() / 1'000'000));
  json->Key("labels").BeginObject();
  for (const auto& [key, value] : LabelsOf(map)) json->Key(key).Text(value);
  json->EndObject();
  json->Key("world_frame");
  if (map.has_world_frame()) {
    WriteWorldFrameJson(map.world_frame(), json);
  } else {
    json->Null();
  }
  json->Key("config");
  WriteConfigJson(map.config(), json);
  json->Key("state");
  WriteStateJson(map.state(), json);
  json->EndObject();
}

void WriteChangedMap(std::string_view done, const v1::Map& map, bool as_json, std::ostream* out) {
  if (!as_json) {
    *out << done << ' ' << map.name() << '\n';
    return;
  }
  JsonWriter json;
  WriteMapJson(map, &json);
  *out << json.Finish();
}

}  // namespace steadymap
