#pragma once

#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

#include <absl/status/statusor.h>

#include "client/bench/evaluation/method/method.h"
#include "client/bench/evaluation/report/evaluation.h"
#include "client/bench/simulator/simulation.h"

namespace steadymap {

/// Options of an evaluation on a simulated route.
struct RouteEvaluationOptions {
  SimulationOptions simulation;            ///< Its seed is replaced.
  std::vector<std::uint64_t> seeds = {1};  ///< Never empty.
  double voxel_size_m = 0.2;
  bool with_ground = false;  ///< Scores the voxels of the ground, too.
  std::vector<Method> methods;
  MapVisitor visit_map;  ///< For the maps of the first seed; may be empty.
  /// Receives the ground truth before the first frame; may be empty.
  std::function<void(const Reference&)> visit_reference;
  std::function<void()> on_frame;  ///< Called after each frame; may be empty.
};

/// Plays `route` once per seed, each frame through all methods, and scores the resulting maps. Uses
/// one thread, so that the measured times are comparable. Errors: those of `Mapper::Create`.
absl::StatusOr<Evaluation> EvaluateRoute(const Route& route, const RouteEvaluationOptions& options);

/// Returns the common configuration of maps of a route, as in the paper.
MapConfig MapConfigFor(std::string_view route);

/// Returns the default voxel size of the scores of a route, metres.
double EvaluationVoxelFor(std::string_view route);

/// Returns the spacing of surface samples for scores on voxels of `voxel_size_m`.
double SampleSpacingFor(double voxel_size_m);

}  // namespace steadymap
