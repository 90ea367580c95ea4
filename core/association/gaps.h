#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/integration/semantic_cloud.h"

namespace steadymap {

/// Where one row or column of cells of a frame looks between two surfaces beside each other.
struct GapInView {
  Eigen::Vector2i begin = Eigen::Vector2i::Zero();  ///< Column and row of the last cell before it,
  Eigen::Vector2i end = Eigen::Vector2i::Zero();    ///< and of the first one behind it.
  Eigen::Vector3d middle_world = Eigen::Vector3d::Zero();  ///< Between both surfaces, metres.
  /// Horizontal direction in which the frame looks through the gap, of unit length.
  Eigen::Vector2d view_world = Eigen::Vector2d::UnitX();
  double width_m = 0.0;
  /// Largest angle between the direction and the gap, radians: its width by the horizontal way that
  /// the ray goes on behind the surfaces.
  double max_angle_rad = 0.0;
};

/// The constants of `FindGaps`.
struct GapParameters {
  /// Things that are farther apart are not seen as one, metres.
  double max_width_m = 0.3;
  /// Largest difference of two depths that noise makes, standard deviations.
  double max_sigmas = 3.0;
  /// Largest angle between the way across a gap and the level, as a cosine.
  double min_level_cosine = 0.85;
  /// Fewest rows or columns of the frame that show a gap.
  std::size_t min_lines = 3;

  friend bool operator==(const GapParameters&, const GapParameters&) = default;
};

/// Finds the gaps that a frame looks through: pairs of cells of one class and without instance,
/// beside each other in the world, with surface between them that is farther away than both, by
/// more than their distance. Gaps between things above each other do not count: what is above a gap
/// stands on something.
std::vector<GapInView> FindGaps(const SemanticCloud& cloud, const GapParameters& parameters);

}  // namespace steadymap
