#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "core/frame/frame.h"

namespace steadymap {

/// A polyline to be drawn with a round pen, pixels, y down. A single point is a disc.
using Stroke = std::vector<Eigen::Vector2d>;

/// A picture with anti-aliased drawing functions, by cairo. Coordinates are pixels, x right, y
/// down; the centre of the top left pixel is (0.5, 0.5). Shapes are clipped to the picture. Colours
/// are mixed in sRGB. Not thread-safe.
class Canvas {
 public:
  Canvas(int width_px, int height_px, const Rgb& background);
  ~Canvas();
  Canvas(Canvas&&) noexcept;
  Canvas& operator=(Canvas&&) noexcept;

  int width_px() const { return width_px_; }

  int height_px() const { return height_px_; }

  /// Returns a copy of the picture.
  Image<Rgb> image() const;

  /// Mixes `color` into a pixel; `opacity` in [0, 1]. No effect outside the picture.
  void Blend(int u, int v, const Rgb& color, double opacity);

  /// Copies another picture into this one, with its top left corner at pixel (`u`, `v`).
  void Paste(const Canvas& other, int u, int v);

  /// Fills the box between two corners.
  void FillBox(const Eigen::Vector2d& low_px, const Eigen::Vector2d& high_px, const Rgb& color);

  /// Outlines the box between two corners, one pixel wide.
  void DrawBox(const Eigen::Vector2d& low_px, const Eigen::Vector2d& high_px, const Rgb& color);

  /// Draws lines with a round pen. Crossings within one call do not darken.
  void DrawStrokes(const std::vector<Stroke>& strokes, double width_px, const Rgb& color);

  /// Fills a disc.
  void FillDisc(const Eigen::Vector2d& center_px, double radius_px, const Rgb& color);

  /// Writes a line of text with its baseline starting at `origin_px` and capitals of height
  /// `cap_height_px`. ASCII only; a control byte becomes a question mark, and so does each run of
  /// bytes above 127.
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
  /// Surface and context of cairo, whose headers only the source file includes.
  struct Drawing;

  void SetColor(const Rgb& color);
  void AddToPath(const Stroke& stroke, double margin_px);

  int width_px_;
  int height_px_;
  std::unique_ptr<Drawing> drawing_;
};

/// Returns the advance width of a line of text as `Canvas::Write` draws it, pixels. 0 for empty
/// text.
double TextWidth(std::string_view text, double cap_height_px);

/// Interpolates linearly per channel from `from` (weight 0) to `to` (weight 1).
Rgb Mix(const Rgb& from, const Rgb& to, double weight);

}  // namespace steadymap
