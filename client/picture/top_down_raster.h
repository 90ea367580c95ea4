#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include <Eigen/Core>

#include "core/frame/frame.h"
#include "core/volume/mesh.h"

namespace steadymap {

/// The world rectangle of a picture that looks vertically down: world x to the right, y upwards.
struct TopDownView {
  /// World position of the pixel coordinate (0, 0), metres.
  Eigen::Vector2d top_left_world = Eigen::Vector2d::Zero();
  double metres_per_px = 0.01;
  int width_px = 0;
  int height_px = 0;

  /// Returns the pixel coordinates of a point; the centre of the top left pixel is (0.5, 0.5).
  Eigen::Vector2d PixelOf(const Eigen::Vector2d& point_world) const {
    return Eigen::Vector2d(point_world.x() - top_left_world.x(),
                           top_left_world.y() - point_world.y()) /
           metres_per_px;
  }
};

/// The topmost surface at each pixel of a view.
struct TopDownRaster {
  /// Height of a pixel without surface.
  static constexpr float kNothing = -std::numeric_limits<float>::infinity();

  Image<float> height_m;  ///< World z, or kNothing.
  Image<float> light;     ///< Reflected light in [0, 1]; the lamp is in the north-west.
  Image<Rgb> color;       ///< The mesh's colours; empty if it has none.
};

/// Draws the surface up to the height `cut_height_m`.
///
/// Surface that faces down was observed from below and would hide the surface under it, so it is
/// omitted. Steep surface (walls, sides of boxes) is nearly edge-on and would vanish, so its edges
/// are drawn as lines about `line_px` wide. Cost: one pass over the triangles and their pixels.
TopDownRaster DrawTopDown(const Mesh& mesh,
                          const TopDownView& view,
                          double cut_height_m,
                          int line_px);

/// True if a triangle is drawn: finite, not above `cut_height_m`, not facing down.
bool IsDrawnTopDown(const Mesh& mesh,
                    const std::array<std::uint32_t, 3>& triangle,
                    double cut_height_m);

/// Returns the cosine of the angle between a triangle's normal and the vertical: 1 faces up, -1
/// down; 0 if it is degenerate.
float UpwardCosine(const Mesh& mesh, const std::array<std::uint32_t, 3>& triangle);

}  // namespace steadymap
