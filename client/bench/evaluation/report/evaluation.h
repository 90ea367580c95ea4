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

namespace steadymap {

/// What is said of one method on one route.
struct MethodScore {
  std::string name;
  bool last_sequence_only = false;  ///< So it cannot notice changes, and has no events to score.
  MapScore map;                     ///< Counts of all seeds together.
  EventScore events;                ///< The same.
  /// Brier score of the map's beliefs (`belief_score.h`); NaN where it has none.
  double brier = std::numeric_limits<double>::quiet_NaN();
  MapCost cost;  ///< Of the last seed.
};

/// One table.
struct Evaluation {
  std::string title;  ///< Of the route or recording.
  double voxel_size_m = 0.2;
  std::size_t frame_count = 0;    ///< A seed.
  std::size_t skipped_count = 0;  ///< Frames of a recording that could not be used.
  std::size_t seed_count = 1;
  bool has_history = false;  ///< Whether the scores of ghosts, memory and events mean anything.
  std::size_t scored_voxels = 0;  ///< Observed voxels that count.
  std::vector<MethodScore> rows;
};

/// Sees each final map, to draw it.
using MapVisitor = std::function<void(
    const std::string& method, const MapScorer& scorer, const std::vector<SurfacePoint>& surface)>;

}  // namespace steadymap
