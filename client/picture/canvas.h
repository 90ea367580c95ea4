#pragma once

#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "client/picture/stroke_font.h"
#include "core/frame/frame.h"

namespace steadymap {

/// A picture with anti-aliased drawing functions. Coordinates are pixels, x right, y down; the
/// centre of the top left pixel is (0.5, 0.5). Shapes are clipped to the picture. Colours are mixed
/// in sRGB. Not thread-safe.
class Canvas {
 public:
  Canvas(int width_px, int height_px, const Rgb& background);

  int width_px() const { return image_.width_px(); }

  int height_px() const { return image_.height_px(); }

  const Image<Rgb>& image() const { return image_; }

  /// Mixes `color` into a pixel; `opacity` in [0, 1]. No effect outside the picture.
  void Blend(int u, int v, const Rgb& color, double opacity);

  /// Fills the box between two corners.
  void FillBox(const Eigen::Vector2d& low_px, const Eigen::Vector2d& high_px, const Rgb& color);

  /// Outlines the box between two corners, one pixel wide.
  void DrawBox(const Eigen::Vector2d& low_px, const Eigen::Vector2d& high_px, const Rgb& color);

  /// Draws lines with a round pen. Crossings within one call do not darken.
  void DrawStrokes(const std::vector<Stroke>& strokes, double width_px, const Rgb& color);

  /// Fills a disc.
  void FillDisc(const Eigen::Vector2d& center_px, double radius_px, const Rgb& color);

  /// Writes a line of text with its baseline starting at `origin_px`.
  void Write(std::string_view text,
             const Eigen::Vector2d& origin_px,
             double cap_height_px,
             const Rgb& color);

  /// Writes a line of text with its baseline ending at `end_px`.
  void WriteRightAligned(std::string_view text,
                         const Eigen::Vector2d& end_px,
                         double cap_height_px,
                         const Rgb& color);

 private:
  Image<Rgb> image_;
};

/// Interpolates linearly per channel from `from` (weight 0) to `to` (weight 1).
Rgb Mix(const Rgb& from, const Rgb& to, double weight);

}  // namespace steadymap
