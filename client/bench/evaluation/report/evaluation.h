#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "client/bench/evaluation/method/method_run.h"
#include "client/bench/evaluation/score/event_score.h"
#include "client/bench/evaluation/score/map_score.h"
#include "client/bench/evaluation/score/pose_score.h"

namespace steadymap {

/// Scores of one method on one route.
struct MethodScore {
  std::string name;
  bool last_sequence_only = false;        ///< It observes no changes, so it has no event scores.
  MapScore map;                           ///< Counts of all seeds together.
  EventScore events;                      ///< Counts of all seeds together.
  std::vector<std::string> event_faults;  ///< Of the last seed, see `event_faults.h`.
  /// Brier score of the map's beliefs (`belief_score.h`); NaN if it has none.
  double brier = std::numeric_limits<double>::quiet_NaN();
  PoseScore registered_poses;  ///< Of all seeds together; no points if it registers no frames.
  MapCost cost;                ///< Of the last seed.
};

/// One table.
struct Evaluation {
  std::string title;  ///< Of the route or recording.
  double voxel_size_m = 0.2;
  std::size_t frame_count = 0;    ///< Per seed.
  std::size_t skipped_count = 0;  ///< Unusable frames of a recording.
  std::size_t seed_count = 1;
  bool has_history = false;       ///< The scores of ghosts, memory and events are valid.
  std::size_t scored_voxels = 0;  ///< Observed voxels that are scored.
  PoseScore claimed_poses;        ///< Of all seeds together; no points for a recording.
  std::vector<MethodScore> rows;
};

/// Receives each final map, e.g. to draw it.
using MapVisitor = std::function<void(
    const std::string& method, const MapScorer& scorer, const MethodOutcome& outcome)>;

}  // namespace steadymap
