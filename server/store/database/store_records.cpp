#include "server/store/database/store_records.h"

#include <array>

#include <absl/strings/str_cat.h>

#include "core/types/crc32c.h"
#include "core/types/error.h"
#include "server/store/database/corrupt_record.h"
#include "server/store/database/store_keys.h"

#include "steadymap/storage/v1/records.pb.h"

namespace steadymap {
namespace {

constexpr std::size_t kEnvelopeBytes = 5;
constexpr int kPoseNumbers = 12;
constexpr int kPoseColumns = 4;

std::uint32_t Checksum(const ValuePlace& place, char version, std::string_view payload) {
  std::uint32_t crc = ExtendCrc32c(0, place.column_family);
  crc = ExtendCrc32c(crc, std::string_view("\0", 1));
  crc = ExtendCrc32c(crc, place.key);
  crc = ExtendCrc32c(crc, std::string_view(&version, 1));
  return ExtendCrc32c(crc, payload);
}

std::uint32_t ToNumber(UpdatePolicy policy) {
  switch (policy) {
    case UpdatePolicy::kStatic:
      return 1;
    case UpdatePolicy::kVoxelChange:
      return 2;
    case UpdatePolicy::kSubmapChange:
      return 3;
    case UpdatePolicy::kTracking:
      return 4;
    case UpdatePolicy::kPocd:
      return 5;
    case UpdatePolicy::kPocdPaper:
      return 6;
  }
  return 0;
}

std::uint32_t ToNumber(ClassMotion motion) {
  switch (motion) {
    case ClassMotion::kStatic:
      return 1;
    case ClassMotion::kSemiStatic:
      return 2;
    case ClassMotion::kDynamic:
      return 3;
  }
  return 0;
}

absl::StatusOr<MapConfig> ConfigFromProto(const storage::v1::MapConfig& config) {
  if (config.policy() < 1 || config.policy() > 6) {
    return CorruptRecord("a map record contains an unknown update policy");
  }
  static constexpr std::array kPolicies = {UpdatePolicy::kStatic,
                                           UpdatePolicy::kVoxelChange,
                                           UpdatePolicy::kSubmapChange,
                                           UpdatePolicy::kTracking,
                                           UpdatePolicy::kPocd,
                                           UpdatePolicy::kPocdPaper};
  MapConfig result;
  result.policy = kPolicies.at(config.policy() - 1);
  result.voxel_size_m = config.voxel_size_m();
  result.truncation_m = config.truncation_m();
  result.max_depth_m = config.max_depth_m();
  result.parameters.insert(config.parameters().begin(), config.parameters().end());
  result.classes.clear();
  for (const storage::v1::SemanticClass& row : config.classes()) {
    absl::StatusOr<SemanticClass> read = FromProto(row);
    if (!read.ok()) return read.status();
    result.classes.push_back(*std::move(read));
  }
  return result;
}

}  // namespace

std::string Seal(const ValuePlace& place, std::string_view payload) {
  std::string value(1, static_cast<char>(kRecordVersion));
  const std::uint32_t crc = Checksum(place, value.front(), payload);
  for (int shift = 0; shift < 32; shift += 8) {
    value.push_back(static_cast<char>(static_cast<unsigned char>(crc >> shift)));
  }
  value.append(payload);
  return value;
}

absl::StatusOr<std::string_view> Unseal(const ValuePlace& place, std::string_view value) {
  if (value.size() < kEnvelopeBytes) return DamagedValue(place, "is truncated");
  const std::string_view payload = value.substr(kEnvelopeBytes);
  std::uint32_t crc = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    crc |= static_cast<std::uint32_t>(static_cast<unsigned char>(value[1 + i])) << (8 * i);
  }
  if (crc != Checksum(place, value.front(), payload)) {
    return DamagedValue(place, "does not match its checksum");
  }
  const auto version = static_cast<std::uint8_t>(value.front());
  if (version == 0 || version > kRecordVersion) {
    return absl::FailedPreconditionError(absl::StrCat("the store was written by a newer server: ",
                                                      "record version at most ",
                                                      kRecordVersion,
                                                      " expected, got ",
                                                      version));
  }
  return payload;
}

absl::Status DamagedValue(const ValuePlace& place, std::string_view what) {
  return MakeError(
      absl::StatusCode::kDataLoss,
      reason::kChecksum,
      absl::StrCat("the value of key ",
                   KeyAsHex(place.key),
                   " in column family ",
                   absl::string_view(place.column_family.data(), place.column_family.size()),
                   " ",
                   absl::string_view(what.data(), what.size())));
}

namespace {

storage::v1::WorldFrame WorldFrameToProto(const WorldFrame& frame) {
  storage::v1::WorldFrame proto;
  proto.set_description(frame.description);
  proto.set_floor(frame.floor);
  if (frame.anchor) {
    for (const double number : {frame.anchor->latitude_deg,
                                frame.anchor->longitude_deg,
                                frame.anchor->altitude_m,
                                frame.anchor->heading_deg}) {
      proto.add_anchor(number);
    }
  }
  return proto;
}

WorldFrame WorldFrameFromProto(const storage::v1::WorldFrame& proto) {
  WorldFrame frame{proto.description(), proto.floor(), std::nullopt};
  if (proto.anchor_size() == 4) {
    frame.anchor = {proto.anchor(0), proto.anchor(1), proto.anchor(2), proto.anchor(3)};
  }
  return frame;
}

}  // namespace

storage::v1::MapRecord ToProto(const MapRecord& record) {
  storage::v1::MapRecord proto;
  proto.set_key(record.key.value());
  proto.set_tenant(record.name.tenant);
  proto.set_map(record.name.map);
  proto.set_display_name(record.display_name);
  storage::v1::MapConfig& config = *proto.mutable_config();
  config.set_voxel_size_m(record.config.voxel_size_m);
  config.set_truncation_m(record.config.truncation_m);
  config.set_max_depth_m(record.config.max_depth_m);
  config.set_policy(ToNumber(record.config.policy));
  config.mutable_parameters()->insert(record.config.parameters.begin(),
                                      record.config.parameters.end());
  for (const SemanticClass& row : record.config.classes) *config.add_classes() = ToProto(row);
  proto.set_frame_log_age_s(record.frame_log_age.count());
  proto.set_frame_log_bytes(record.frame_log_bytes);
  proto.set_byte_budget(record.byte_budget);
  proto.set_max_commit_delay_ms(record.max_commit_delay.count());
  proto.set_create_time_ns(record.create_time.nanoseconds());
  proto.set_incarnation(record.incarnation);
  proto.set_request_id(record.request_id);
  proto.set_change_request_id(record.change_request_id);
  proto.mutable_labels()->insert(record.labels.begin(), record.labels.end());
  *proto.mutable_world_frame() = WorldFrameToProto(record.world_frame);
  proto.set_version(record.version);
  return proto;
}

absl::StatusOr<MapRecord> FromProto(const storage::v1::MapRecord& record) {
  absl::StatusOr<MapConfig> config = ConfigFromProto(record.config());
  if (!config.ok()) return config.status();
  MapRecord result;
  result.key = MapKey{record.key()};
  result.name = {record.tenant(), record.map()};
  result.display_name = record.display_name();
  result.config = *std::move(config);
  result.frame_log_age = std::chrono::seconds(record.frame_log_age_s());
  result.frame_log_bytes = record.frame_log_bytes();
  result.byte_budget = record.byte_budget();
  result.max_commit_delay = std::chrono::milliseconds(record.max_commit_delay_ms());
  result.create_time = Timestamp::FromNanoseconds(record.create_time_ns());
  result.incarnation = record.incarnation();
  result.request_id = record.request_id();
  result.change_request_id = record.change_request_id();
  result.labels = {record.labels().begin(), record.labels().end()};
  result.world_frame = WorldFrameFromProto(record.world_frame());
  result.version = record.version();
  return result;
}

storage::v1::SessionRecord ToProto(const SessionRecord& record) {
  storage::v1::SessionRecord proto;
  proto.set_robot(record.name.sensor.robot);
  proto.set_sensor(record.name.sensor.sensor);
  proto.set_session(record.name.session);
  proto.set_settled(record.settled.Pack());
  proto.set_last_map_seq(record.last_map_seq.value());
  proto.set_last_active_uptime_ns(record.last_active.count());
  proto.set_last_active_time_ns(record.last_active_time.nanoseconds());
  proto.set_is_over(record.is_over);
  return proto;
}

absl::StatusOr<SessionRecord> FromProto(const storage::v1::SessionRecord& record) {
  absl::StatusOr<SequenceSet> settled = SequenceSet::Unpack(record.settled());
  if (!settled.ok()) return settled.status();
  return SessionRecord{{{record.robot(), record.sensor()}, record.session()},
                       *std::move(settled),
                       MapSequence{record.last_map_seq()},
                       MapUptime(record.last_active_uptime_ns()),
                       Timestamp::FromNanoseconds(record.last_active_time_ns()),
                       record.is_over()};
}

storage::v1::PoseRecord ToProto(const FramePose& pose) {
  storage::v1::PoseRecord record;
  record.set_robot(pose.source.robot);
  record.set_sensor(pose.source.sensor);
  record.set_capture_time_ns(pose.capture_time.nanoseconds());
  for (int i = 0; i < kPoseNumbers; ++i) {
    record.add_t_world_camera(pose.T_world_camera.matrix()(i / kPoseColumns, i % kPoseColumns));
  }
  return record;
}

absl::StatusOr<FramePose> FromProto(MapSequence sequence, const storage::v1::PoseRecord& record) {
  if (record.t_world_camera_size() != kPoseNumbers) {
    return CorruptRecord("a pose record does not contain a rigid transform");
  }
  FramePose pose;
  pose.sequence = sequence;
  pose.source = {record.robot(), record.sensor()};
  pose.capture_time = Timestamp::FromNanoseconds(record.capture_time_ns());
  for (int i = 0; i < kPoseNumbers; ++i) {
    pose.T_world_camera.matrix()(i / kPoseColumns, i % kPoseColumns) = record.t_world_camera(i);
  }
  return pose;
}

storage::v1::SemanticClass ToProto(const SemanticClass& row) {
  storage::v1::SemanticClass proto;
  proto.set_id(row.id.value());
  proto.set_name(row.name);
  proto.set_motion(ToNumber(row.motion));
  proto.set_in_background(row.in_background);
  return proto;
}

absl::StatusOr<SemanticClass> FromProto(const storage::v1::SemanticClass& row) {
  if (row.motion() < 1 || row.motion() > 3 || row.id() > 0xFFFF) {
    return CorruptRecord("a record contains an invalid class");
  }
  static constexpr std::array kMotions = {
      ClassMotion::kStatic, ClassMotion::kSemiStatic, ClassMotion::kDynamic};
  return SemanticClass{ClassId{static_cast<std::uint16_t>(row.id())},
                       row.name(),
                       kMotions.at(row.motion() - 1),
                       row.in_background()};
}

}  // namespace steadymap
