#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "client/bench/evaluation/report/evaluation.h"
#include "client/dataset/dataset.h"

namespace steadymap {

/// How recorded sequences are evaluated.
struct RecordingEvaluationOptions {
  std::string format;                              ///< As for `OpenDataset`.
  std::vector<std::filesystem::path> sequences{};  ///< One path each, in the order of the drives.
  DatasetOptions dataset{};
  double voxel_size_m = 0.2;
  std::vector<Method> methods{};  ///< Holds one that is shown the last sequence only (asserted).
  MapVisitor visit_map{};         ///< May be empty.
};

/// Plays the sequences through all methods at a time. As in the paper, the truth is the map of that
/// method which is shown the last sequence only, so it scores full marks; there is no truth about
/// ghosts, memory and events. Frames that cannot be read are skipped and counted.
/// Errors: as `OpenDataset` and `Mapper::Create`; `InvalidArgument` with the first frame's error if
/// a sequence has no usable frame.
absl::StatusOr<Evaluation> EvaluateRecording(const RecordingEvaluationOptions& options);

}  // namespace steadymap
