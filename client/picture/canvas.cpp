#include "client/picture/canvas.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <new>
#include <optional>
#include <string>
#include <utility>

#include <cairo.h>

namespace steadymap {
namespace {

// The family that fontconfig chooses for it is installed with cairo on Debian.
constexpr char kFontFamily[] = "sans-serif";

struct FontDeleter {
  void operator()(cairo_scaled_font_t* font) const { cairo_scaled_font_destroy(font); }
};

using Font = std::unique_ptr<cairo_scaled_font_t, FontDeleter>;

/// Creates the font whose em is `size_px`. Glyphs are not fitted to pixels, so text scales exactly.
Font MakeFont(double size_px) {
  cairo_font_options_t* options = cairo_font_options_create();
  cairo_font_options_set_antialias(options, CAIRO_ANTIALIAS_GRAY);
  cairo_font_options_set_hint_style(options, CAIRO_HINT_STYLE_NONE);
  cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
  cairo_font_face_t* face =
      cairo_toy_font_face_create(kFontFamily, CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  cairo_matrix_t em;
  cairo_matrix_t identity;
  cairo_matrix_init_scale(&em, size_px, size_px);
  cairo_matrix_init_identity(&identity);
  Font font(cairo_scaled_font_create(face, &em, &identity, options));
  cairo_font_face_destroy(face);
  cairo_font_options_destroy(options);
  return font;
}

cairo_text_extents_t ExtentsOf(const std::string& text, const Font& font) {
  cairo_text_extents_t extents;
  cairo_scaled_font_text_extents(font.get(), text.c_str(), &extents);
  return extents;
}

Font MakeFontWithCaps(double cap_height_px) {
  constexpr double kSampleEmPx = 100.0;
  const double sample_cap_px = ExtentsOf("H", MakeFont(kSampleEmPx)).height;
  return MakeFont(cap_height_px * kSampleEmPx / std::max(sample_cap_px, 1.0));
}

std::string ToPrintableAscii(std::string_view text) {
  std::string printable;
  bool in_run = false;
  for (const char byte : text) {
    const auto code = static_cast<unsigned char>(byte);
    const bool is_foreign = code > 127;
    if (!is_foreign || !in_run) printable += code < 0x20 || code > 0x7E ? '?' : byte;
    in_run = is_foreign;
  }
  return printable;
}

/// The part of a segment inside of a box (Liang and Barsky, 1984); none if there is none. Cairo's
/// coordinates are 24 bits before the point, so that it cannot clip lines of any length itself.
std::optional<std::pair<Eigen::Vector2d, Eigen::Vector2d>> ClipSegment(
    const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Eigen::AlignedBox2d& box) {
  const Eigen::Vector2d along = to - from;
  double enter = 0.0;
  double leave = 1.0;
  for (int axis = 0; axis < 2; ++axis) {
    if (along[axis] == 0.0) {
      if (from[axis] < box.min()[axis] || from[axis] > box.max()[axis]) return std::nullopt;
      continue;
    }
    const double at_min = (box.min()[axis] - from[axis]) / along[axis];
    const double at_max = (box.max()[axis] - from[axis]) / along[axis];
    enter = std::max(enter, std::min(at_min, at_max));
    leave = std::min(leave, std::max(at_min, at_max));
  }
  if (!(enter <= leave)) return std::nullopt;
  return std::pair(Eigen::Vector2d(from + enter * along), Eigen::Vector2d(from + leave * along));
}

std::uint32_t ToPixel(const Rgb& color) {
  return static_cast<std::uint32_t>(color[0]) << 16 | static_cast<std::uint32_t>(color[1]) << 8 |
         color[2];
}

Rgb FromPixel(std::uint32_t pixel) {
  return {static_cast<std::uint8_t>(pixel >> 16),
          static_cast<std::uint8_t>(pixel >> 8),
          static_cast<std::uint8_t>(pixel)};
}

/// Row `v` of a surface of the format RGB24: a pixel a word.
std::uint32_t* RowOf(cairo_surface_t* surface, int v) {
  return reinterpret_cast<std::uint32_t*>(cairo_image_surface_get_data(surface) +
                                          static_cast<std::ptrdiff_t>(v) *
                                              cairo_image_surface_get_stride(surface));
}

}  // namespace

Rgb Mix(const Rgb& from, const Rgb& to, double weight) {
  Rgb mixed;
  for (std::size_t i = 0; i < mixed.size(); ++i) {
    mixed[i] = static_cast<std::uint8_t>(std::lround(from[i] + (to[i] - from[i]) * weight));
  }
  return mixed;
}

struct Canvas::Drawing {
  Drawing(int width_px, int height_px)
      : surface(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width_px, height_px)),
        context(cairo_create(surface)) {}

  ~Drawing() {
    cairo_destroy(context);
    cairo_surface_destroy(surface);
  }

  Drawing(const Drawing&) = delete;
  Drawing& operator=(const Drawing&) = delete;

  cairo_surface_t* const surface;
  cairo_t* const context;
};

Canvas::Canvas(int width_px, int height_px, const Rgb& background)
    : width_px_(width_px),
      height_px_(height_px),
      drawing_(std::make_unique<Drawing>(width_px, height_px)) {
  if (cairo_status(drawing_->context) != CAIRO_STATUS_SUCCESS) throw std::bad_alloc();
  SetColor(background);
  cairo_paint(drawing_->context);
  cairo_set_line_cap(drawing_->context, CAIRO_LINE_CAP_ROUND);
  cairo_set_line_join(drawing_->context, CAIRO_LINE_JOIN_ROUND);
}

Canvas::~Canvas() = default;
Canvas::Canvas(Canvas&&) noexcept = default;
Canvas& Canvas::operator=(Canvas&&) noexcept = default;

Image<Rgb> Canvas::image() const {
  cairo_surface_flush(drawing_->surface);
  Image<Rgb> image(width_px_, height_px_);
  for (int v = 0; v < height_px_; ++v) {
    const std::uint32_t* row = RowOf(drawing_->surface, v);
    for (int u = 0; u < width_px_; ++u) image.At(u, v) = FromPixel(row[u]);
  }
  return image;
}

void Canvas::SetColor(const Rgb& color) {
  cairo_set_source_rgb(drawing_->context, color[0] / 255.0, color[1] / 255.0, color[2] / 255.0);
}

void Canvas::Blend(int u, int v, const Rgb& color, double opacity) {
  if (u < 0 || v < 0 || u >= width_px() || v >= height_px() || opacity <= 0.0) return;
  cairo_surface_flush(drawing_->surface);
  std::uint32_t& pixel = RowOf(drawing_->surface, v)[u];
  pixel = ToPixel(Mix(FromPixel(pixel), color, std::min(opacity, 1.0)));
  cairo_surface_mark_dirty_rectangle(drawing_->surface, u, v, 1, 1);
}

void Canvas::Paste(const Canvas& other, int u, int v) {
  cairo_set_source_surface(drawing_->context, other.drawing_->surface, u, v);
  cairo_paint(drawing_->context);
}

void Canvas::FillBox(const Eigen::Vector2d& low_px,
                     const Eigen::Vector2d& high_px,
                     const Rgb& color) {
  const Eigen::Vector2d size(width_px_, height_px_);
  const Eigen::Vector2d low = low_px.cwiseMax(0.0).cwiseMin(size);
  const Eigen::Vector2d extent = high_px.cwiseMax(0.0).cwiseMin(size) - low;
  if (!(extent.minCoeff() > 0.0)) return;
  SetColor(color);
  cairo_rectangle(drawing_->context, low.x(), low.y(), extent.x(), extent.y());
  cairo_fill(drawing_->context);
}

void Canvas::DrawBox(const Eigen::Vector2d& low_px,
                     const Eigen::Vector2d& high_px,
                     const Rgb& color) {
  FillBox(low_px, {high_px.x(), low_px.y() + 1.0}, color);
  FillBox({low_px.x(), high_px.y() - 1.0}, high_px, color);
  FillBox({low_px.x(), low_px.y() + 1.0}, {low_px.x() + 1.0, high_px.y() - 1.0}, color);
  FillBox({high_px.x() - 1.0, low_px.y() + 1.0}, {high_px.x(), high_px.y() - 1.0}, color);
}

void Canvas::AddToPath(const Stroke& stroke, double margin_px) {
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(margin_px);
  const Eigen::AlignedBox2d reach(-margin, Eigen::Vector2d(width_px_, height_px_) + margin);
  std::optional<Eigen::Vector2d> pen;
  for (std::size_t i = 0; i < stroke.size(); ++i) {
    const auto segment = ClipSegment(stroke[i == 0 ? 0 : i - 1], stroke[i], reach);
    if (!segment) continue;
    if (pen != segment->first) {
      cairo_move_to(drawing_->context, segment->first.x(), segment->first.y());
    }
    cairo_line_to(drawing_->context, segment->second.x(), segment->second.y());
    pen = segment->second;
  }
}

void Canvas::DrawStrokes(const std::vector<Stroke>& strokes, double width_px, const Rgb& color) {
  for (const Stroke& stroke : strokes) AddToPath(stroke, width_px);
  SetColor(color);
  cairo_set_line_width(drawing_->context, width_px);
  cairo_stroke(drawing_->context);
}

void Canvas::FillDisc(const Eigen::Vector2d& center_px, double radius_px, const Rgb& color) {
  DrawStrokes({{center_px}}, 2.0 * radius_px, color);
}

void Canvas::Write(std::string_view text,
                   const Eigen::Vector2d& origin_px,
                   double cap_height_px,
                   const Rgb& color) {
  const Eigen::AlignedBox2d picture(Eigen::Vector2d::Zero(),
                                    Eigen::Vector2d(width_px_, height_px_));
  const double width_px = TextWidth(text, cap_height_px);
  const Eigen::AlignedBox2d line(
      Eigen::Vector2d(origin_px - Eigen::Vector2d::Constant(2.0 * cap_height_px)),
      Eigen::Vector2d(origin_px + Eigen::Vector2d(width_px, cap_height_px)));
  if (!picture.intersects(line)) return;
  const Font font = MakeFontWithCaps(cap_height_px);
  cairo_set_scaled_font(drawing_->context, font.get());
  SetColor(color);
  cairo_move_to(drawing_->context, origin_px.x(), origin_px.y());
  cairo_show_text(drawing_->context, ToPrintableAscii(text).c_str());
  cairo_new_path(drawing_->context);
}

void Canvas::WriteRightAligned(std::string_view text,
                               const Eigen::Vector2d& end_px,
                               double cap_height_px,
                               const Rgb& color) {
  Write(text, {end_px.x() - TextWidth(text, cap_height_px), end_px.y()}, cap_height_px, color);
}

double TextWidth(std::string_view text, double cap_height_px) {
  return ExtentsOf(ToPrintableAscii(text), MakeFontWithCaps(cap_height_px)).x_advance;
}

}  // namespace steadymap
