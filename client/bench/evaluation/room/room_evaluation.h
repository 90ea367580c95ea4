#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "client/bench/evaluation/room/room_case.h"
#include "client/bench/evaluation/room/room_score.h"
#include "client/bench/evaluation/score/pose_score.h"

namespace steadymap {

/// Options of an evaluation on box rooms.
struct RoomEvaluationOptions {
  std::vector<RoomChange> changes = AllRoomChanges();
  std::size_t cases = 4;  ///< Per change.
  /// Of every case; if empty, those that `ListRoomCases` draws.
  std::vector<std::string> variations;
  std::uint64_t seed = 1;
  UpdatePolicy policy = UpdatePolicy::kPocd;
  ParameterValues parameters;  ///< Of the policy.
  /// Of every case; without a value, those that `ListRoomCases` draws. Changes that cannot be told
  /// with these labels are left out.
  std::optional<RoomLabels> labels;
  std::function<void()> on_case;  ///< Called after each case; may be empty.
};

/// The result of one case.
struct RoomResult {
  RoomCase room_case;
  RoomScore score;
  double cuboid_tolerance_m = 0.0;
  PoseScore claimed_poses;
  PoseScore registered_poses;  ///< No points if the policy registers no frames.

  bool is_labelled() const { return room_case.labels != RoomLabels::kNone; }

  bool has_right_cuboids() const { return score.worst_cuboid_m <= cuboid_tolerance_m; }
};

/// Plays every case into a map of its own and compares events and objects with the truth. Errors:
/// those of `Mapper::Create`, and `InvalidArgument` if there is no case: two variations of one
/// property, or changes that do not allow the variations or labels.
absl::StatusOr<std::vector<RoomResult>> EvaluateRooms(const RoomEvaluationOptions& options);

/// Returns a table of the share of exact cases and of the RMS errors of the poses: in total, by
/// change and by variation. With `with_faults`, lists the faults of every case, too.
std::string RoomTable(const std::vector<RoomResult>& results, bool with_faults);

}  // namespace steadymap
