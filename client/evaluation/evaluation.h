#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include <absl/status/statusor.h>

#include "client/evaluation/event_score.h"
#include "client/evaluation/map_score.h"
#include "client/evaluation/method.h"
#include "client/evaluation/method_run.h"
#include "client/simulator/simulation.h"

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

/// How a simulated route is evaluated.
struct RouteEvaluationOptions {
  SimulationOptions simulation;            ///< Its seed is replaced.
  std::vector<std::uint64_t> seeds = {1};  ///< Never empty.
  double voxel_size_m = 0.2;
  bool with_ground = false;  ///< Whether the ground's voxels are scored.
  std::vector<Method> methods;
  MapVisitor visit_map;            ///< Of the first seed; may be empty.
  std::function<void()> on_frame;  ///< After each frame; may be empty.
};

/// Plays `route` once a seed through all methods at a time and scores what they made of it. One
/// thread, so that the times mean something.
/// Errors: as `Mapper::Create`.
absl::StatusOr<Evaluation> EvaluateRoute(const Route& route, const RouteEvaluationOptions& options);

/// The configuration that maps of a route have in common: the paper's (pocd.md section 5).
MapConfig MapConfigFor(std::string_view route);

/// The voxel on which a route is scored unless told otherwise, metres.
double EvaluationVoxelFor(std::string_view route);

/// How far apart surface is sampled for scores on voxels of `voxel_size_m`.
double SampleSpacingFor(double voxel_size_m);

}  // namespace steadymap
