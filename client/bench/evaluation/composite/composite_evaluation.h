#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "client/bench/evaluation/composite/composite_score.h"
#include "client/bench/evaluation/method/method.h"
#include "client/bench/evaluation/room/room_case.h"
#include "client/dataset/dataset.h"

namespace steadymap {

/// Options of an evaluation on changes that are drawn into a recording.
struct CompositeEvaluationOptions {
  std::string format;  ///< Of `OpenDataset`.
  std::filesystem::path path{};
  DatasetOptions dataset{};
  RoomLabels labels = RoomLabels::kClasses;
  std::size_t cases = 3;
  std::uint64_t seed = 1;
  double session_offset_m = 0.0;  ///< Length of the pose error of the second drive.
  std::vector<Method> methods{};  ///< At least one.
  /// Called for each frame that is read, with the number of all of them; may be empty.
  std::function<void(std::size_t total)> on_frame{};
};

/// The result of one case with one method.
struct CompositeResult {
  std::size_t number = 0;  ///< Of the case; 0: the recording without things.
  std::string method;
  CompositeScore score;
};

/// Plays a recording as two drives through the same room: its frames with even indices, then those
/// with odd ones. Into each, draws things, which the cases change between the drives. The room is
/// first turned until most level surface faces up. Unreadable frames are skipped. Errors: those of
/// `OpenDataset` and `Mapper::Create`; `InvalidArgument` with the first frame's error if no frame
/// is usable; `FailedPrecondition` if a case finds no place for any thing.
absl::StatusOr<std::vector<CompositeResult>> EvaluateComposite(
    const CompositeEvaluationOptions& options);

/// Returns a table with a row for each case and method, and one for all cases of each method. With
/// `with_faults`, lists the faults of every case, too.
std::string CompositeTable(const std::vector<CompositeResult>& results, bool with_faults);

}  // namespace steadymap
