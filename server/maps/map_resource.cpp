#include "server/maps/map_resource.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include <absl/strings/str_cat.h>
#include <google/protobuf/util/field_mask_util.h>
#include <google/protobuf/util/time_util.h>

#include "core/types/error.h"
#include "proto/convert_geometry.h"
#include "proto/convert_map.h"
#include "server/process/system_clock.h"
#include "server/store/map/map_folder.h"

namespace steadymap {
namespace {

using google::protobuf::FieldMask;
using google::protobuf::util::FieldMaskUtil;

constexpr std::size_t kMaxDisplayNameBytes = 128;
constexpr std::size_t kMaxRequestIdBytes = 64;

// About 100 years; a larger value would overflow in nanoseconds.
constexpr std::int64_t kMaxRetentionSeconds = std::int64_t{100} * 366 * 24 * 3600;

constexpr std::int64_t kMaxCommitDelayMs = 60'000;

// Update path that adds rows to the class table.
constexpr char kClassesPath[] = "config.classes";

absl::Status CheckLength(const char* field, const std::string& text, std::size_t max_bytes) {
  if (text.size() <= max_bytes) return absl::OkStatus();
  return InvalidField(
      reason::kBadValue,
      field,
      absl::StrCat(field, " must have at most ", max_bytes, " bytes, got ", text.size()));
}

absl::StatusOr<std::chrono::seconds> ReadLogAge(const v1::Retention& retention,
                                                const RetentionOptions& defaults) {
  if (!retention.has_frame_log_age()) return defaults.frame_log_age;
  const std::int64_t seconds = retention.frame_log_age().seconds();
  if (seconds < 0 || seconds > kMaxRetentionSeconds || retention.frame_log_age().nanos() < 0) {
    return InvalidField(
        reason::kBadValue,
        "retention.frame_log_age",
        absl::StrCat(
            "frame_log_age must lie in [0, ", kMaxRetentionSeconds, "] seconds, got ", seconds));
  }
  return std::chrono::seconds(seconds);
}

std::uint64_t ReadLogBytes(const v1::Retention& retention, const RetentionOptions& defaults) {
  return retention.frame_log_bytes() > 0 ? retention.frame_log_bytes() : defaults.frame_log_bytes;
}

absl::StatusOr<std::chrono::milliseconds> ReadCommitDelay(const v1::Map& map) {
  const google::protobuf::Duration& delay = map.max_commit_delay();
  if (delay.seconds() == 0 && delay.nanos() == 0) return std::chrono::milliseconds(0);
  const bool in_range = delay.seconds() >= 0 && delay.nanos() >= 0 && delay.seconds() <= 60;
  const std::int64_t milliseconds =
      in_range ? delay.seconds() * 1000 + delay.nanos() / 1'000'000 : 0;
  if (milliseconds < 1 || milliseconds > kMaxCommitDelayMs) {
    return InvalidField(reason::kBadValue,
                        "map.max_commit_delay",
                        absl::StrCat("max_commit_delay must lie in [1 ms, 60 s], got ",
                                     delay.seconds(),
                                     " s and ",
                                     delay.nanos(),
                                     " ns"));
  }
  return std::chrono::milliseconds(milliseconds);
}

absl::Status ReadLabels(const v1::Map& map, std::map<std::string, std::string>* labels) {
  constexpr std::size_t kMaxLabels = 64;
  constexpr std::size_t kMaxValueBytes = 256;
  const auto bad = [](const std::string& text) {
    return InvalidField(reason::kBadValue, "map.labels", text);
  };
  if (static_cast<std::size_t>(map.labels_size()) > kMaxLabels) {
    return bad(absl::StrCat("a map has at most ", kMaxLabels, " labels, got ", map.labels_size()));
  }
  for (const auto& [key, value] : map.labels()) {
    if (IsValidId(key) && value.size() <= kMaxValueBytes) continue;
    return bad(absl::StrCat(
        "the key of a label must match [a-z][a-z0-9-]{0,62} and its value must have at most ",
        kMaxValueBytes,
        " bytes, got \"",
        key.substr(0, 100),
        "\" with ",
        value.size(),
        " bytes"));
  }
  *labels = {map.labels().begin(), map.labels().end()};
  return absl::OkStatus();
}

absl::Status ReadWorldFrame(const v1::WorldFrame& message, WorldFrame* frame) {
  constexpr std::size_t kMaxDescriptionBytes = 512;
  constexpr std::size_t kMaxFloorBytes = 64;
  absl::Status status =
      CheckLength("map.world_frame.description", message.description(), kMaxDescriptionBytes);
  if (status.ok()) status = CheckLength("map.world_frame.floor", message.floor(), kMaxFloorBytes);
  if (!status.ok()) return status;
  frame->description = message.description();
  frame->floor = message.floor();
  frame->anchor.reset();
  if (!message.has_anchor()) return absl::OkStatus();
  const v1::GeoAnchor& anchor = message.anchor();
  const auto lies_in = [](double value, double low, double high) {
    return value >= low && value <= high;  // False for NaN.
  };
  if (!lies_in(anchor.latitude_deg(), -90.0, 90.0) ||
      !lies_in(anchor.longitude_deg(), -180.0, 180.0) ||
      !lies_in(anchor.altitude_m(), -1000.0, 10'000.0) ||
      !lies_in(anchor.heading_deg(), 0.0, 360.0) || anchor.heading_deg() == 360.0) {
    return InvalidField(reason::kBadValue,
                        "map.world_frame.anchor",
                        "latitude must lie in [-90, 90], longitude in [-180, 180] and heading in "
                        "[0, 360) degrees, altitude in [-1000, 10000] metres");
  }
  frame->anchor = {
      anchor.latitude_deg(), anchor.longitude_deg(), anchor.altitude_m(), anchor.heading_deg()};
  return absl::OkStatus();
}

v1::WorldFrame WorldFrameToProto(const WorldFrame& frame) {
  v1::WorldFrame message;
  message.set_description(frame.description);
  message.set_floor(frame.floor);
  if (frame.anchor) {
    message.mutable_anchor()->set_latitude_deg(frame.anchor->latitude_deg);
    message.mutable_anchor()->set_longitude_deg(frame.anchor->longitude_deg);
    message.mutable_anchor()->set_altitude_m(frame.anchor->altitude_m);
    message.mutable_anchor()->set_heading_deg(frame.anchor->heading_deg);
  }
  return message;
}

v1::MapCondition ConditionToProto(MapRuntime::Condition condition) {
  switch (condition) {
    case MapRuntime::Condition::kOpening:
      return v1::MAP_CONDITION_OPENING;
    case MapRuntime::Condition::kReady:
      return v1::MAP_CONDITION_READY;
    case MapRuntime::Condition::kReadOnly:
      return v1::MAP_CONDITION_READ_ONLY;
    case MapRuntime::Condition::kQuarantined:
      return v1::MAP_CONDITION_QUARANTINED;
    case MapRuntime::Condition::kDamaged:
      return v1::MAP_CONDITION_DAMAGED;
    case MapRuntime::Condition::kDeleted:
      break;
  }
  return v1::MAP_CONDITION_UNSPECIFIED;
}

void FillState(const MapRuntime& map, v1::MapState* state) {
  const MapRuntime::Health health = map.health();
  state->set_condition(ConditionToProto(health.condition));
  if (!health.reason.ok()) state->set_condition_reason(std::string(health.reason.message()));
  // The revision is read before the head, so that the head is not older than it.
  const PublishedRevision published = map.published();
  const MapSnapshot& snapshot = *published.snapshot;
  const std::uint64_t integrated = snapshot.integrated().value();
  const std::uint64_t head = std::max(map.durable_head().value(), integrated);
  state->set_revision(snapshot.revision.value());
  state->set_integrated_map_seq(integrated);
  state->set_durable_map_seq(head);
  state->set_lag_frames(head - integrated);
  state->set_refused_frames(map.refused_frames());
  state->set_leaves(published.counts.leaves);
  state->set_voxels(published.counts.voxels);
  state->set_memory_bytes(published.counts.memory_bytes);
  state->set_present_objects(published.counts.present_objects);
  state->set_archived_objects(published.counts.archived_objects);
  if (snapshot.last_capture_time != Timestamp()) {
    *state->mutable_last_capture_time() = ToProto(snapshot.last_capture_time);
  }
}

absl::Status NotChangeable(const std::string& path) {
  return InvalidField(
      reason::kBadValue,
      "update_mask",
      absl::StrCat("display_name, retention, retention.frame_log_age, "
                   "retention.frame_log_bytes, byte_budget, max_commit_delay, "
                   "labels and world_frame can be changed, and rows can be added to "
                   "config.classes; cannot change ",
                   path.substr(0, 100)));
}

absl::Status ApplyPath(const std::string& path,
                       const v1::Map& map,
                       const RetentionOptions& defaults,
                       MapRecord* record) {
  if (path == "display_name") {
    record->display_name = map.display_name();
    return CheckLength("map.display_name", map.display_name(), kMaxDisplayNameBytes);
  }
  if (path == "byte_budget") {
    record->byte_budget = map.byte_budget();
    return absl::OkStatus();
  }
  if (path == "max_commit_delay") {
    const absl::StatusOr<std::chrono::milliseconds> delay = ReadCommitDelay(map);
    if (!delay.ok()) return delay.status();
    record->max_commit_delay = *delay;
    return absl::OkStatus();
  }
  if (path == "labels") return ReadLabels(map, &record->labels);
  if (path == "world_frame") return ReadWorldFrame(map.world_frame(), &record->world_frame);
  const bool whole_retention = path == "retention";
  if (!whole_retention && path != "retention.frame_log_age" &&
      path != "retention.frame_log_bytes") {
    return NotChangeable(path);
  }
  if (path != "retention.frame_log_age") {
    record->frame_log_bytes = ReadLogBytes(map.retention(), defaults);
  }
  if (path != "retention.frame_log_bytes") {
    const absl::StatusOr<std::chrono::seconds> age = ReadLogAge(map.retention(), defaults);
    if (!age.ok()) return WithFieldPrefix(age.status(), "map");
    record->frame_log_age = *age;
  }
  return absl::OkStatus();
}

}  // namespace

std::string TenantOf(const std::string& parent) {
  constexpr std::string_view kPrefix = "tenants/";
  return parent.starts_with(kPrefix) ? parent.substr(kPrefix.size()) : std::string();
}

v1::Map MakeMapResource(const MapRuntime& map) {
  const MapRecord record = map.record();
  v1::Map resource;
  resource.set_name(record.name.ToString());
  resource.set_etag(EtagOf(record));
  FillState(map, resource.mutable_state());
  if (!record.condition.ok()) return resource;
  resource.set_display_name(record.display_name);
  MapConfig config = record.config;
  // Empty while the map is not open; the resource then contains the initial classes.
  if (std::vector<SemanticClass> classes = map.classes(); !classes.empty()) {
    config.classes = std::move(classes);
  }
  *resource.mutable_config() = ToProto(config);
  resource.mutable_labels()->insert(record.labels.begin(), record.labels.end());
  if (record.world_frame != WorldFrame()) {
    *resource.mutable_world_frame() = WorldFrameToProto(record.world_frame);
  }
  resource.mutable_retention()->mutable_frame_log_age()->set_seconds(record.frame_log_age.count());
  resource.mutable_retention()->set_frame_log_bytes(record.frame_log_bytes);
  resource.set_byte_budget(record.byte_budget);
  if (record.max_commit_delay.count() > 0) {
    *resource.mutable_max_commit_delay() =
        google::protobuf::util::TimeUtil::MillisecondsToDuration(record.max_commit_delay.count());
  }
  *resource.mutable_create_time() = ToProto(record.create_time);
  resource.set_incarnation(record.incarnation);
  return resource;
}

std::string EtagOf(const MapRecord& record) {
  return absl::StrCat(record.key.value(), "-", record.version);
}

absl::Status CheckEtag(const MapRecord& record, const std::string& etag, std::string_view field) {
  if (etag.empty() || etag == EtagOf(record)) return absl::OkStatus();
  return MakeError(
      absl::StatusCode::kAborted,
      reason::kEtagMismatch,
      absl::StrCat(
          "the map has changed: its etag is ", EtagOf(record), ", not ", etag.substr(0, 100)),
      field);
}

absl::Status CheckRequestId(const std::string& request_id) {
  return CheckLength("request_id", request_id, kMaxRequestIdBytes);
}

absl::StatusOr<MapRecord> ReadNewMap(const v1::CreateMapRequest& request,
                                     const RetentionOptions& defaults) {
  MapRecord record;
  const std::string& parent = request.parent();
  record.name.tenant = TenantOf(parent);
  if (!IsValidId(record.name.tenant)) {
    return InvalidField(reason::kBadName,
                        "parent",
                        absl::StrCat("parent must be tenants/{tenant}, with an id that matches "
                                     "[a-z][a-z0-9-]{0,62}, got \"",
                                     parent.substr(0, 100),
                                     "\""));
  }
  record.name.map = request.map_id();
  if (!IsValidId(record.name.map)) {
    return InvalidField(reason::kBadName,
                        "map_id",
                        absl::StrCat("map_id must match [a-z][a-z0-9-]{0,62}, got \"",
                                     request.map_id().substr(0, 100),
                                     "\""));
  }
  absl::Status status = CheckRequestId(request.request_id());
  if (!status.ok()) return status;
  absl::StatusOr<MapConfig> config = FromProto(request.map().config());
  if (!config.ok()) return WithFieldPrefix(config.status(), "map.config");
  record.config = *std::move(config);
  for (const char* path :
       {"display_name", "retention", "byte_budget", "max_commit_delay", "labels", "world_frame"}) {
    if (status = ApplyPath(path, request.map(), defaults, &record); !status.ok()) return status;
  }
  record.create_time = Now();
  record.incarnation = NewIncarnation();
  record.request_id = request.request_id();
  return record;
}

absl::Status ApplyUpdate(const v1::Map& map,
                         const FieldMask& mask,
                         const RetentionOptions& defaults,
                         MapRecord* record) {
  if (mask.paths().empty()) {
    return InvalidField(
        reason::kBadValue, "update_mask", "update_mask must name at least one field");
  }
  for (const std::string& path : mask.paths()) {
    if (path == kClassesPath) continue;
    if (absl::Status status = ApplyPath(path, map, defaults, record); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<SemanticClass>> ReadAddedClasses(
    const v1::Map& map, const FieldMask& mask, const std::vector<SemanticClass>& present) {
  const bool is_asked =
      std::find(mask.paths().begin(), mask.paths().end(), kClassesPath) != mask.paths().end();
  if (!is_asked) return std::vector<SemanticClass>();
  absl::StatusOr<std::vector<SemanticClass>> table = ReadClasses(map.config());
  if (!table.ok()) return WithFieldPrefix(table.status(), "map.config");
  for (const SemanticClass& row : present) {
    const auto kept = std::find(table->begin(), table->end(), row);
    if (kept == table->end()) {
      return InvalidField(reason::kBadValue,
                          "map.config.classes",
                          absl::StrCat("classes can only be added: the row of class ",
                                       row.id.value(),
                                       ", \"",
                                       row.name,
                                       "\", must remain unchanged"));
    }
    table->erase(kept);
  }
  return table;
}

absl::Status ApplyReadMask(const FieldMask& mask, v1::Map* map) {
  if (mask.paths().empty()) return absl::OkStatus();
  for (const std::string& path : mask.paths()) {
    if (FieldMaskUtil::IsValidPath<v1::Map>(path)) continue;
    return InvalidField(
        reason::kBadValue, "read_mask", absl::StrCat("a map has no field ", path.substr(0, 100)));
  }
  FieldMaskUtil::TrimMessage(mask, map);
  return absl::OkStatus();
}

}  // namespace steadymap
