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

/// The configuration that maps of a route have in common: POCD's (Qian et al., RSS 2022).
MapConfig MapConfigFor(std::string_view route);

/// The voxel on which a route is scored unless told otherwise, metres.
double EvaluationVoxelFor(std::string_view route);

/// How far apart surface is sampled for scores on voxels of `voxel_size_m`.
double SampleSpacingFor(double voxel_size_m);

}  // namespace steadymap
