#include "client/cli/maps/map_text.h"

#include <algorithm>
#include <iomanip>
#include <map>
#include <string>
#include <utility>

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

/// Returns the parameters in the order of their names; messages keep them in none.
std::map<std::string, double> SortedParameters(const v1::MapConfig& config) {
  return {config.parameters().begin(), config.parameters().end()};
}

std::string ParametersText(const v1::MapConfig& config) {
  return absl::StrJoin(SortedParameters(config), ", ", absl::PairFormatter("="));
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

Json ConfigJson(const v1::MapConfig& config) {
  Json classes = Json::array();
  for (const v1::SemanticClass& semantic_class : config.classes()) {
    classes.push_back({{"id", semantic_class.id()},
                       {"name", semantic_class.name()},
                       {"motion", MotionText(semantic_class.motion())},
                       {"in_background", semantic_class.in_background()}});
  }
  Json parameters = Json::object();
  for (const auto& [name, value] : SortedParameters(config)) parameters[name] = value;
  return {{"voxel_size_m", config.voxel_size_m()},
          {"truncation_m", config.truncation_m()},
          {"max_depth_m", config.max_depth_m()},
          {"policy", PolicyText(config.policy())},
          {"parameters", std::move(parameters)},
          {"classes", std::move(classes)}};
}

// Returns null if there is none.
Json AnchorJson(const v1::WorldFrame& frame) {
  if (!frame.has_anchor()) return nullptr;
  return {{"latitude_deg", frame.anchor().latitude_deg()},
          {"longitude_deg", frame.anchor().longitude_deg()},
          {"altitude_m", frame.anchor().altitude_m()},
          {"heading_deg", frame.anchor().heading_deg()}};
}

// Returns null if there is none.
Json WorldFrameJson(const v1::Map& map) {
  if (!map.has_world_frame()) return nullptr;
  return {{"description", map.world_frame().description()},
          {"floor", map.world_frame().floor()},
          {"anchor", AnchorJson(map.world_frame())}};
}

// Returns null if there is none.
Json LastCaptureJson(const v1::MapState& state) {
  if (!state.has_last_capture_time()) return nullptr;
  return TimeText(state.last_capture_time());
}

Json StateJson(const v1::MapState& state) {
  return {{"revision", state.revision()},
          {"durable_map_seq", state.durable_map_seq()},
          {"integrated_map_seq", state.integrated_map_seq()},
          {"lag_frames", state.lag_frames()},
          {"refused_frames", state.refused_frames()},
          {"present_objects", state.present_objects()},
          {"archived_objects", state.archived_objects()},
          {"leaves", state.leaves()},
          {"voxels", state.voxels()},
          {"memory_bytes", state.memory_bytes()},
          {"last_capture_time", LastCaptureJson(state)},
          {"condition", ConditionWord(state)},
          {"condition_reason", state.condition_reason()}};
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
  if (config.parameters_size() > 0) WriteFact("parameters", ParametersText(config), out);
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

Json MapJson(const v1::Map& map) {
  const auto& delay = map.max_commit_delay();
  return {{"name", map.name()},
          {"display_name", map.display_name()},
          {"create_time", TimeText(map.create_time())},
          {"etag", map.etag()},
          {"incarnation", map.incarnation()},
          {"byte_budget", map.byte_budget()},
          {"max_commit_delay_ms", delay.seconds() * 1000 + delay.nanos() / 1'000'000},
          {"labels", LabelsOf(map)},
          {"world_frame", WorldFrameJson(map)},
          {"config", ConfigJson(map.config())},
          {"state", StateJson(map.state())}};
}

void WriteChangedMap(std::string_view done, const v1::Map& map, bool as_json, std::ostream* out) {
  if (!as_json) {
    *out << done << ' ' << map.name() << '\n';
    return;
  }
  *out << IndentedJson(MapJson(map));
}

}  // namespace steadymap
