#include "server/store/database/robot_records.h"

#include <cmath>

#include <Eigen/Cholesky>

#include "core/types/error.h"
#include "server/store/database/corrupt_record.h"

#include "steadymap/storage/v1/records.pb.h"

namespace steadymap {
namespace {

constexpr std::uint32_t kTrusts = static_cast<std::uint32_t>(Trust::kLost) + 1;
constexpr int kMotionNumbers = 6;

using Floats = google::protobuf::RepeatedField<float>;
using Doubles = google::protobuf::RepeatedField<double>;

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

/// Adds the upper triangle of a symmetric matrix, row by row.
template <int Size>
void AddTriangle(const Eigen::Matrix<double, Size, Size>& matrix, Doubles* numbers) {
  for (int row = 0; row < Size; ++row) {
    for (int column = row; column < Size; ++column) numbers->Add(matrix(row, column));
  }
}

template <int Size>
bool HasTriangle(const Doubles& numbers) {
  return numbers.size() == Size * (Size + 1) / 2;
}

/// Returns the symmetric matrix of a triangle. `HasTriangle` must hold.
template <int Size>
Eigen::Matrix<double, Size, Size> MatrixOf(const Doubles& numbers) {
  Eigen::Matrix<double, Size, Size> matrix;
  int next = 0;
  for (int row = 0; row < Size; ++row) {
    for (int column = row; column < Size; ++column) {
      matrix(row, column) = numbers[next++];
      matrix(column, row) = matrix(row, column);
    }
  }
  return matrix;
}

void OffsetToProto(const PoseOffset& offset, storage::v1::PoseOffset* proto) {
  proto->set_time_ns(offset.time.nanoseconds());
  for (const double number : offset.center_world) proto->add_center(number);
  for (const double number : offset.shift_world) proto->add_shift(number);
  proto->set_yaw(offset.yaw_rad);
  AddTriangle<4>(offset.covariance, proto->mutable_covariance());
  proto->set_anchors(offset.anchors);
}

absl::StatusOr<PoseOffset> OffsetFromProto(const storage::v1::PoseOffset& proto) {
  if (proto.center_size() != 3 || proto.shift_size() != 3 || !HasTriangle<4>(proto.covariance()) ||
      proto.anchors() == 0) {
    return CorruptRecord("a robot record does not contain a pose offset");
  }
  PoseOffset offset;
  offset.time = Timestamp::FromNanoseconds(proto.time_ns());
  offset.center_world = {proto.center(0), proto.center(1), proto.center(2)};
  offset.shift_world = {proto.shift(0), proto.shift(1), proto.shift(2)};
  offset.yaw_rad = proto.yaw();
  offset.covariance = MatrixOf<4>(proto.covariance());
  offset.anchors = proto.anchors();
  if (!offset.center_world.allFinite() || !offset.shift_world.allFinite() ||
      !std::isfinite(offset.yaw_rad) || !offset.covariance.allFinite()) {
    return CorruptRecord("a robot record contains a pose offset that is not finite");
  }
  return offset;
}

void PoseErrorToProto(const PoseErrorEstimate& estimate, storage::v1::PoseErrorEstimate* proto) {
  proto->set_time_ns(estimate.time.nanoseconds());
  for (const PoseErrorHypothesis& hypothesis : estimate.hypotheses) {
    storage::v1::PoseErrorHypothesis* entry = proto->add_hypotheses();
    for (const double number : hypothesis.error.mean) entry->add_mean(number);
    AddTriangle<6>(hypothesis.error.covariance, entry->mutable_covariance());
    entry->set_probability(hypothesis.probability);
  }
}

absl::StatusOr<PoseErrorEstimate> PoseErrorFromProto(const storage::v1::PoseErrorEstimate& proto) {
  PoseErrorEstimate estimate;
  estimate.time = Timestamp::FromNanoseconds(proto.time_ns());
  if (proto.hypotheses_size() != static_cast<int>(kPoseErrorHypotheses)) {
    return CorruptRecord("a robot record does not contain the hypotheses of a pose error");
  }
  for (int i = 0; i < proto.hypotheses_size(); ++i) {
    const storage::v1::PoseErrorHypothesis& entry = proto.hypotheses(i);
    if (entry.mean_size() != PoseErrorVector::RowsAtCompileTime ||
        !HasTriangle<6>(entry.covariance())) {
      return CorruptRecord("a robot record does not contain a pose error");
    }
    PoseErrorHypothesis& hypothesis = estimate.hypotheses[static_cast<std::size_t>(i)];
    hypothesis.error.mean = Eigen::Map<const PoseErrorVector>(entry.mean().data());
    hypothesis.error.covariance = MatrixOf<6>(entry.covariance());
    hypothesis.probability = entry.probability();
    if (!hypothesis.error.mean.allFinite() || !hypothesis.error.covariance.allFinite() ||
        Eigen::LLT<Eigen::MatrixXd>(hypothesis.error.covariance).info() != Eigen::Success ||
        !(hypothesis.probability >= 0.0 && hypothesis.probability <= 1.0)) {
      return CorruptRecord("a robot record contains a pose error that is not valid");
    }
  }
  return estimate;
}

}  // namespace

storage::v1::RobotRecord ToProto(const RobotState& state) {
  storage::v1::RobotRecord record;
  record.set_trust(static_cast<std::uint32_t>(state.trust) + 1);
  record.set_claimed_log_odds(state.claimed_log_odds);
  record.set_likely_log_odds(state.likely_log_odds);
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
  if (state.pose_error) PoseErrorToProto(*state.pose_error, record.mutable_pose_error());
  return record;
}

absl::StatusOr<RobotState> FromProto(const storage::v1::RobotRecord& record) {
  if (record.trust() < 1 || record.trust() > kTrusts ||
      (record.motion_size() != 0 && record.motion_size() != kMotionNumbers)) {
    return CorruptRecord("a robot record does not contain a valid robot");
  }
  RobotState state;
  state.trust = static_cast<Trust>(record.trust() - 1);
  state.claimed_log_odds = record.claimed_log_odds();
  state.likely_log_odds = record.likely_log_odds();
  if (!std::isfinite(state.claimed_log_odds) || !std::isfinite(state.likely_log_odds)) {
    return CorruptRecord("a robot record contains log-odds that are not finite");
  }
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
  if (record.has_pose_error()) {
    absl::StatusOr<PoseErrorEstimate> estimate = PoseErrorFromProto(record.pose_error());
    if (!estimate.ok()) return estimate.status();
    state.pose_error = *std::move(estimate);
  }
  return state;
}

}  // namespace steadymap
