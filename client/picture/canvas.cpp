#include "client/picture/canvas.h"

#include <algorithm>
#include <cmath>

namespace steadymap {
namespace {

// Pen width of text, as a share of the capitals' height.
constexpr double kPenShare = 0.13;

// Pixels that a shape may touch: columns and rows in [low, high).
struct PixelBox {
  Eigen::Vector2i low;
  Eigen::Vector2i high;

  bool empty() const { return low.x() >= high.x() || low.y() >= high.y(); }
};

double DistanceToSegment(const Eigen::Vector2d& point,
                         const Eigen::Vector2d& from,
                         const Eigen::Vector2d& to) {
  const Eigen::Vector2d along = to - from;
  const double length_squared = along.squaredNorm();
  if (length_squared == 0.0) return (point - from).norm();
  const double share = std::clamp((point - from).dot(along) / length_squared, 0.0, 1.0);
  return (point - from - share * along).norm();
}

// Returns the covered share of a pixel at `distance_px` from a line with half-width `reach_px`, for
// a straight edge.
double Coverage(double distance_px, double reach_px) {
  return std::clamp(reach_px - distance_px + 0.5, 0.0, 1.0);
}

Eigen::Vector2d PixelCenter(int u, int v) { return {u + 0.5, v + 0.5}; }

// Returns the visible part of the box from `low` to `high`. Clamps before rounding, since strokes
// may have any coordinates.
PixelBox Clip(const Eigen::Vector2d& low, const Eigen::Vector2d& high, const Image<Rgb>& image) {
  const Eigen::Vector2d size(image.width_px(), image.height_px());
  const Eigen::Vector2d zero = Eigen::Vector2d::Zero();
  const Eigen::Vector2d clipped_low = low.cwiseMax(zero).cwiseMin(size);
  const Eigen::Vector2d clipped_high = high.cwiseMax(zero).cwiseMin(size);
  return {clipped_low.array().floor().cast<int>().matrix(),
          clipped_high.array().ceil().cast<int>().matrix()};
}

}  // namespace

Rgb Mix(const Rgb& from, const Rgb& to, double weight) {
  Rgb mixed;
  for (std::size_t i = 0; i < mixed.size(); ++i) {
    mixed[i] = static_cast<std::uint8_t>(std::lround(from[i] + (to[i] - from[i]) * weight));
  }
  return mixed;
}

Canvas::Canvas(int width_px, int height_px, const Rgb& background)
    : image_(width_px, height_px, background) {}

void Canvas::Blend(int u, int v, const Rgb& color, double opacity) {
  if (u < 0 || v < 0 || u >= width_px() || v >= height_px() || opacity <= 0.0) return;
  image_.At(u, v) = Mix(image_.At(u, v), color, std::min(opacity, 1.0));
}

void Canvas::FillBox(const Eigen::Vector2d& low_px,
                     const Eigen::Vector2d& high_px,
                     const Rgb& color) {
  const PixelBox box = Clip(low_px, high_px, image_);
  for (int v = box.low.y(); v < box.high.y(); ++v) {
    for (int u = box.low.x(); u < box.high.x(); ++u) {
      const Eigen::Vector2d pixel(u, v);
      const Eigen::Vector2d covered =
          high_px.cwiseMin(pixel + Eigen::Vector2d::Ones()) - low_px.cwiseMax(pixel);
      Blend(u, v, color, std::max(covered.x(), 0.0) * std::max(covered.y(), 0.0));
    }
  }
}

void Canvas::DrawBox(const Eigen::Vector2d& low_px,
                     const Eigen::Vector2d& high_px,
                     const Rgb& color) {
  FillBox(low_px, {high_px.x(), low_px.y() + 1.0}, color);
  FillBox({low_px.x(), high_px.y() - 1.0}, high_px, color);
  FillBox({low_px.x(), low_px.y() + 1.0}, {low_px.x() + 1.0, high_px.y() - 1.0}, color);
  FillBox({high_px.x() - 1.0, low_px.y() + 1.0}, {high_px.x(), high_px.y() - 1.0}, color);
}

void Canvas::DrawStrokes(const std::vector<Stroke>& strokes, double width_px, const Rgb& color) {
  const double reach_px = width_px / 2.0;
  const Eigen::Vector2d border = Eigen::Vector2d::Constant(reach_px + 1.0);
  Eigen::AlignedBox2d extent;
  for (const Stroke& stroke : strokes) {
    for (const Eigen::Vector2d& point : stroke) extent.extend(point);
  }
  if (extent.isEmpty()) return;
  const PixelBox all = Clip(extent.min() - border, extent.max() + border, image_);
  if (all.empty()) return;

  Image<float> coverage(all.high.x() - all.low.x(), all.high.y() - all.low.y());
  const auto cover_segment = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    const PixelBox box = Clip(from.cwiseMin(to) - border, from.cwiseMax(to) + border, image_);
    for (int v = box.low.y(); v < box.high.y(); ++v) {
      for (int u = box.low.x(); u < box.high.x(); ++u) {
        float& pixel = coverage.At(u - all.low.x(), v - all.low.y());
        const double distance_px = DistanceToSegment(PixelCenter(u, v), from, to);
        pixel = std::max(pixel, static_cast<float>(Coverage(distance_px, reach_px)));
      }
    }
  };
  for (const Stroke& stroke : strokes) {
    for (std::size_t i = 0; i < stroke.size(); ++i) {
      cover_segment(stroke[i == 0 ? 0 : i - 1], stroke[i]);
    }
  }
  for (int v = all.low.y(); v < all.high.y(); ++v) {
    for (int u = all.low.x(); u < all.high.x(); ++u) {
      Blend(u, v, color, static_cast<double>(coverage.At(u - all.low.x(), v - all.low.y())));
    }
  }
}

void Canvas::FillDisc(const Eigen::Vector2d& center_px, double radius_px, const Rgb& color) {
  DrawStrokes({{center_px}}, 2.0 * radius_px, color);
}

void Canvas::Write(std::string_view text,
                   const Eigen::Vector2d& origin_px,
                   double cap_height_px,
                   const Rgb& color) {
  DrawStrokes(
      TextStrokes(text, origin_px, cap_height_px), std::max(1.3, kPenShare * cap_height_px), color);
}

void Canvas::WriteRightAligned(std::string_view text,
                               const Eigen::Vector2d& end_px,
                               double cap_height_px,
                               const Rgb& color) {
  Write(text, {end_px.x() - TextWidth(text, cap_height_px), end_px.y()}, cap_height_px, color);
}

}  // namespace steadymap
