#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "client/bench/evaluation/report/evaluation.h"
#include "client/dataset/dataset.h"

namespace steadymap {

/// Options of an evaluation on recorded sequences.
struct RecordingEvaluationOptions {
  std::string format;                              ///< Format of `OpenDataset`.
  std::vector<std::filesystem::path> sequences{};  ///< One path each, in the order of recording.
  DatasetOptions dataset{};
  double voxel_size_m = 0.2;
  std::vector<Method> methods{};  ///< One has `last_sequence_only` (asserted).
  MapVisitor visit_map{};         ///< May be empty.
};

/// Plays the sequences, each frame through all methods. As in the paper, the map of the method
/// with `last_sequence_only` is the ground truth, so that method scores 100 %; recordings have no
/// truth for ghosts, memory and events. Unreadable frames are skipped and counted. Errors: those of
/// `OpenDataset` and `Mapper::Create`; `InvalidArgument` with the first frame's error if a sequence
/// has no usable frame.
absl::StatusOr<Evaluation> EvaluateRecording(const RecordingEvaluationOptions& options);

}  // namespace steadymap
