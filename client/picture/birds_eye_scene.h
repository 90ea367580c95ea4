#pragma once

#include <limits>

#include <Eigen/Geometry>

#include "client/picture/birds_eye.h"

/// Private to the bird's-eye picture: selection of the visible part of a map.
namespace steadymap {

/// The visible part of a map.
struct BirdsEyeScene {
  bool has_surface = false;
  double cut_height_m = std::numeric_limits<double>::infinity();
  Eigen::AlignedBox2d extent_world;  ///< Metres, never empty; all sides longer than 0.
  double lowest_m = 0.0;             ///< Height of the ramp's first colour.
  double highest_m = 1.0;            ///< Height of its last colour; above `lowest_m`.
};

/// Chooses the visible part as documented at `DrawBirdsEye`.
BirdsEyeScene ChooseScene(const Mesh& mesh,
                          const std::vector<RobotPath>& paths,
                          const BirdsEyeOptions& options);

}  // namespace steadymap
