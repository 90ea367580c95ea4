#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include <Eigen/Core>

#include "core/frame/frame.h"
#include "core/volume/mesh.h"

namespace steadymap {

/// Where the world lies in a picture that looks straight down: world x to the right, y upwards.
struct TopDownView {
  Eigen::Vector2d top_left_world =
      Eigen::Vector2d::Zero();  ///< At pixel coordinate (0, 0), metres.
  double metres_per_px = 0.01;
  int width_px = 0;
  int height_px = 0;

  /// Pixel coordinates of a point; the centre of the top left pixel is (0.5, 0.5).
  Eigen::Vector2d PixelOf(const Eigen::Vector2d& point_world) const {
    return Eigen::Vector2d(point_world.x() - top_left_world.x(),
                           top_left_world.y() - point_world.y()) /
           metres_per_px;
  }
};

/// The topmost surface under each pixel of a view.
struct TopDownRaster {
  /// Height where there is no surface.
  static constexpr float kNothing = -std::numeric_limits<float>::infinity();

  Image<float> height_m;  ///< World z, or kNothing.
  Image<float>
      light;         ///< Light that the surface reflects, in [0, 1]; the lamp is in the north-west.
  Image<Rgb> color;  ///< The mesh's colours; empty if it has none.
};

/// Draws the surface up to the height `cut_height_m`.
///
/// What faces down was seen from below; from above it would hide what lies under it, and is left
/// out. What is steep (walls, sides of boxes) would be seen edge-on and vanish, so its edges are
/// drawn as lines about `line_px` wide. Cost: one pass over the triangles and the pixels they
/// cover.
TopDownRaster DrawTopDown(const Mesh& mesh,
                          const TopDownView& view,
                          double cut_height_m,
                          int line_px);

/// Whether a triangle is drawn up to `cut_height_m`: finite, not above it, not facing down.
bool IsDrawnTopDown(const Mesh& mesh,
                    const std::array<std::uint32_t, 3>& triangle,
                    double cut_height_m);

/// Cosine of the angle between a triangle and the vertical: 1 faces up, -1 down; 0 if it is
/// degenerate.
float UpwardCosine(const Mesh& mesh, const std::array<std::uint32_t, 3>& triangle);

}  // namespace steadymap
