#pragma once

#include <limits>

#include <Eigen/Geometry>

#include "client/picture/birds_eye.h"

/// Private to the bird's-eye picture: what of a map is worth showing.
namespace steadymap {

/// What a picture shows.
struct BirdsEyeScene {
  bool has_surface = false;
  double cut_height_m = std::numeric_limits<double>::infinity();
  Eigen::AlignedBox2d extent_world;  ///< Never empty, metres; all sides longer than 0.
  double lowest_m = 0.0;             ///< Height that gets the ramp's first colour.
  double highest_m = 1.0;            ///< Height that gets its last; above `lowest_m`.
};

/// Chooses it as `DrawBirdsEye` documents.
BirdsEyeScene ChooseScene(const Mesh& mesh,
                          const std::vector<RobotPath>& paths,
                          const BirdsEyeOptions& options);

}  // namespace steadymap
