#include "server/store/database/robot_records.h"

#include <cmath>

#include "core/types/error.h"
#include "server/store/database/corrupt_record.h"

#include "steadymap/storage/v1/records.pb.h"

namespace steadymap {
namespace {

constexpr std::uint32_t kTrusts = static_cast<std::uint32_t>(Trust::kLost) + 1;
constexpr int kMotionNumbers = 6;
constexpr int kCovarianceNumbers = 10;

using Floats = google::protobuf::RepeatedField<float>;

void Add(const Eigen::Vector3f& vector, Floats* numbers) {
  for (const float number : vector) numbers->Add(number);
}

Eigen::Vector3f VectorAt(const Floats& numbers, int first) {
  return {numbers[first], numbers[first + 1], numbers[first + 2]};
}

void PlaceToProto(const CameraPlace& place, storage::v1::CameraPlace* proto) {
  for (const double number : place.position_world) proto->add_position(number);
  Add(place.rotation_world, proto->mutable_rotation());
}

absl::StatusOr<CameraPlace> PlaceFromProto(const storage::v1::CameraPlace& proto) {
  if (proto.position_size() != 3 || proto.rotation_size() != 3) {
    return CorruptRecord("a robot record does not contain a camera pose");
  }
  const CameraPlace place{{proto.position(0), proto.position(1), proto.position(2)},
                          VectorAt(proto.rotation(), 0)};
  if (!place.position_world.allFinite() || !place.rotation_world.allFinite()) {
    return CorruptRecord("a robot record contains a camera pose that is not finite");
  }
  return place;
}

void MovingToProto(const MovingCell& moving, storage::v1::MovingCell* proto) {
  proto->set_x(moving.cell.x);
  proto->set_y(moving.cell.y);
  proto->set_z(moving.cell.z);
  proto->set_seen_ns(moving.seen.nanoseconds());
  proto->set_is_confirmed(moving.is_confirmed);
}

MovingCell MovingFromProto(const storage::v1::MovingCell& proto) {
  return {{proto.x(), proto.y(), proto.z()},
          Timestamp::FromNanoseconds(proto.seen_ns()),
          proto.is_confirmed()};
}

void OffsetToProto(const PoseOffset& offset, storage::v1::PoseOffset* proto) {
  proto->set_time_ns(offset.time.nanoseconds());
  for (const double number : offset.center_world) proto->add_center(number);
  for (const double number : offset.shift_world) proto->add_shift(number);
  proto->set_yaw(offset.yaw_rad);
  for (int row = 0; row < 4; ++row) {
    for (int column = row; column < 4; ++column)
      proto->add_covariance(offset.covariance(row, column));
  }
  proto->set_anchors(offset.anchors);
}

absl::StatusOr<PoseOffset> OffsetFromProto(const storage::v1::PoseOffset& proto) {
  if (proto.center_size() != 3 || proto.shift_size() != 3 ||
      proto.covariance_size() != kCovarianceNumbers || proto.anchors() == 0) {
    return CorruptRecord("a robot record does not contain a pose offset");
  }
  PoseOffset offset;
  offset.time = Timestamp::FromNanoseconds(proto.time_ns());
  offset.center_world = {proto.center(0), proto.center(1), proto.center(2)};
  offset.shift_world = {proto.shift(0), proto.shift(1), proto.shift(2)};
  offset.yaw_rad = proto.yaw();
  int next = 0;
  for (int row = 0; row < 4; ++row) {
    for (int column = row; column < 4; ++column) {
      offset.covariance(row, column) = proto.covariance(next++);
      offset.covariance(column, row) = offset.covariance(row, column);
    }
  }
  offset.anchors = proto.anchors();
  if (!offset.center_world.allFinite() || !offset.shift_world.allFinite() ||
      !std::isfinite(offset.yaw_rad) || !offset.covariance.allFinite()) {
    return CorruptRecord("a robot record contains a pose offset that is not finite");
  }
  return offset;
}

}  // namespace

storage::v1::RobotRecord ToProto(const RobotState& state) {
  storage::v1::RobotRecord record;
  record.set_trust(static_cast<std::uint32_t>(state.trust) + 1);
  record.set_streak(state.streak);
  record.set_last_capture_time_ns(state.last_capture_time.nanoseconds());
  PlaceToProto(state.claimed, record.mutable_claimed());
  if (state.likely != state.claimed) PlaceToProto(state.likely, record.mutable_likely());
  const Eigen::Vector3f still = Eigen::Vector3f::Zero();
  if (state.velocity_m_per_s != still || state.turn_rad_per_s != still) {
    Add(state.velocity_m_per_s, record.mutable_motion());
    Add(state.turn_rad_per_s, record.mutable_motion());
  }
  for (const MovingCell& moving : state.moving) MovingToProto(moving, record.add_moving());
  if (state.session_start) record.set_session_start_ns(state.session_start->nanoseconds());
  if (state.offset) OffsetToProto(*state.offset, record.mutable_offset());
  return record;
}

absl::StatusOr<RobotState> FromProto(const storage::v1::RobotRecord& record) {
  if (record.trust() < 1 || record.trust() > kTrusts ||
      (record.motion_size() != 0 && record.motion_size() != kMotionNumbers)) {
    return CorruptRecord("a robot record does not contain a valid robot");
  }
  RobotState state;
  state.trust = static_cast<Trust>(record.trust() - 1);
  state.streak = record.streak();
  state.last_capture_time = Timestamp::FromNanoseconds(record.last_capture_time_ns());
  const absl::StatusOr<CameraPlace> claimed = PlaceFromProto(record.claimed());
  if (!claimed.ok()) return claimed.status();
  state.claimed = *claimed;
  const absl::StatusOr<CameraPlace> likely =
      record.has_likely() ? PlaceFromProto(record.likely()) : claimed;
  if (!likely.ok()) return likely.status();
  state.likely = *likely;
  if (record.motion_size() == kMotionNumbers) {
    state.velocity_m_per_s = VectorAt(record.motion(), 0);
    state.turn_rad_per_s = VectorAt(record.motion(), 3);
  }
  if (!state.velocity_m_per_s.allFinite() || !state.turn_rad_per_s.allFinite()) {
    return CorruptRecord("a robot record contains a motion that is not finite");
  }
  for (const storage::v1::MovingCell& proto : record.moving()) {
    const MovingCell moving = MovingFromProto(proto);
    if (!state.moving.empty() && state.moving.back().cell >= moving.cell) {
      return CorruptRecord("the cells of a robot record are not sorted");
    }
    state.moving.push_back(moving);
  }
  if (record.has_session_start_ns()) {
    state.session_start = Timestamp::FromNanoseconds(record.session_start_ns());
  }
  if (record.has_offset()) {
    absl::StatusOr<PoseOffset> offset = OffsetFromProto(record.offset());
    if (!offset.ok()) return offset.status();
    state.offset = *std::move(offset);
  }
  return state;
}

}  // namespace steadymap
