#include "client/picture/birds_eye_legend.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "client/picture/height_ramp.h"
#include "client/picture/picture_style.h"

namespace steadymap {
namespace {

constexpr Rgb kGridLine = {226, 228, 231};
constexpr Rgb kStartMark = {0, 135, 95};
constexpr Rgb kEndMark = {190, 30, 45};

constexpr double kPathWidthPx = 3.0;
constexpr double kCasingWidthPx = 6.0;
constexpr double kMarkRadiusPx = 7.0;
constexpr std::size_t kMaxPathRows = 8;
constexpr double kSampleWidthPx = 26.0;
constexpr double kTextOffsetPx = 36.0;

// Distinguishable from each other and from the ramp with any kind of colour vision; the first robot
// gets the strongest colour.
constexpr std::array<Rgb, 8> kPathColors = {{{224, 82, 6},
                                             {200, 24, 130},
                                             {20, 20, 20},
                                             {150, 100, 20},
                                             {235, 150, 0},
                                             {120, 10, 40},
                                             {90, 90, 90},
                                             {240, 90, 110}}};

void DrawStartMark(const Eigen::Vector2d& center_px, Canvas* canvas) {
  canvas->FillDisc(center_px, kMarkRadiusPx + 2.0, kWhite);
  canvas->FillDisc(center_px, kMarkRadiusPx, kStartMark);
}

void DrawEndMark(const Eigen::Vector2d& center_px, Canvas* canvas) {
  const Eigen::Vector2d outer = Eigen::Vector2d::Constant(kMarkRadiusPx + 1.5);
  const Eigen::Vector2d inner = Eigen::Vector2d::Constant(kMarkRadiusPx - 0.5);
  canvas->FillBox(center_px - outer, center_px + outer, kWhite);
  canvas->FillBox(center_px - inner, center_px + inner, kEndMark);
}

// Returns the pixel coordinates of a path without points closer than half a pixel.
Stroke StrokeOf(const RobotPath& path, const TopDownView& view) {
  Stroke stroke;
  for (const Eigen::Vector3d& position : path.positions_world) {
    if (!position.allFinite()) continue;
    const Eigen::Vector2d point_px = view.PixelOf(position.head<2>());
    if (stroke.empty() || (point_px - stroke.back()).norm() > 0.5) stroke.push_back(point_px);
  }
  return stroke;
}

void DrawArrow(const Eigen::Vector2d& from_px, const Eigen::Vector2d& to_px, Canvas* canvas) {
  const Eigen::Vector2d back = (from_px - to_px).normalized() * 7.0;
  const Eigen::Vector2d side = Eigen::Vector2d(-back.y(), back.x()) * 0.6;
  canvas->DrawStrokes(
      {{from_px, to_px}, {to_px + back + side, to_px, to_px + back - side}}, 1.8, kInk);
}

}  // namespace

double RoundLength(double limit) {
  const double power = std::pow(10.0, std::floor(std::log10(limit)));
  for (const double factor : {5.0, 2.0}) {
    if (factor * power <= limit) return factor * power;
  }
  return power;
}

std::string Decimal(double value) {
  // Six digits: prints 0.30000000000000004 as 0.3. Adding 0 turns -0 into 0.
  std::array<char, 32> text{};
  const double rounded = std::round(value * 1e6) / 1e6 + 0.0;
  const std::to_chars_result result =
      std::to_chars(text.data(), text.data() + text.size(), rounded, std::chars_format::general, 6);
  return {text.data(), result.ptr};
}

Rgb PathColor(std::size_t path) { return kPathColors[path % kPathColors.size()]; }

void DrawGrid(const TopDownView& view, double step_m, Canvas* canvas) {
  const Eigen::Vector2d low_world =
      view.top_left_world - Eigen::Vector2d(0.0, canvas->height_px() * view.metres_per_px);
  const Eigen::Vector2d size_m =
      Eigen::Vector2d(canvas->width_px(), canvas->height_px()) * view.metres_per_px;
  const Eigen::Vector2d first = (low_world / step_m).array().ceil().matrix();
  const int columns = static_cast<int>(size_m.x() / step_m) + 1;
  const int rows = static_cast<int>(size_m.y() / step_m) + 1;
  for (int i = 0; i < columns; ++i) {
    const double u = std::floor(view.PixelOf({(first.x() + i) * step_m, 0.0}).x());
    canvas->FillBox({u, 0.0}, {u + 1.0, canvas->height_px()}, kGridLine);
  }
  for (int i = 0; i < rows; ++i) {
    const double v = std::floor(view.PixelOf({0.0, (first.y() + i) * step_m}).y());
    canvas->FillBox({0.0, v}, {canvas->width_px(), v + 1.0}, kGridLine);
  }
}

void DrawPaths(const std::vector<RobotPath>& paths, const TopDownView& view, Canvas* canvas) {
  std::vector<Stroke> strokes;
  strokes.reserve(paths.size());
  for (const RobotPath& path : paths) strokes.push_back(StrokeOf(path, view));
  canvas->DrawStrokes(strokes, kCasingWidthPx, kWhite);
  for (std::size_t i = 0; i < strokes.size(); ++i) {
    canvas->DrawStrokes({strokes[i]}, kPathWidthPx, PathColor(i));
  }
  for (const Stroke& stroke : strokes) {
    if (stroke.empty()) continue;
    // Draws the end first: if a robot returned to its start, the smaller disc stays visible in the
    // box.
    DrawEndMark(stroke.back(), canvas);
    canvas->FillDisc(stroke.front(), kMarkRadiusPx * 0.75 + 1.5, kWhite);
    canvas->FillDisc(stroke.front(), kMarkRadiusPx * 0.75, kStartMark);
  }
}

void DrawScaleBar(double length_m,
                  double metres_per_px,
                  const Eigen::Vector2i& origin_px,
                  Canvas* canvas) {
  constexpr int kParts = 4;
  constexpr double kBarHeightPx = 8.0;
  const Eigen::Vector2d low = origin_px.cast<double>();
  const Eigen::Vector2d high = low + Eigen::Vector2d(length_m / metres_per_px, kBarHeightPx);
  canvas->FillBox(low, high, kWhite);
  for (int part = 0; part < kParts; part += 2) {
    const double from = low.x() + (high.x() - low.x()) * part / kParts;
    const double to = low.x() + (high.x() - low.x()) * (part + 1) / kParts;
    canvas->FillBox({from, low.y()}, {to, high.y()}, kInk);
  }
  canvas->DrawBox(low, high, kInk);
  const double baseline = high.y() + 8.0 + kSmallTextPx;
  canvas->Write("0", {low.x(), baseline}, kSmallTextPx, kInk);
  canvas->WriteRightAligned(Decimal(length_m) + " m", {high.x(), baseline}, kSmallTextPx, kInk);
}

void DrawAxes(const Eigen::Vector2d& origin_px, Canvas* canvas) {
  constexpr double kArrowPx = 30.0;
  const Eigen::Vector2d x_end = origin_px + Eigen::Vector2d(kArrowPx, 0.0);
  const Eigen::Vector2d y_end = origin_px - Eigen::Vector2d(0.0, kArrowPx);
  DrawArrow(origin_px, x_end, canvas);
  DrawArrow(origin_px, y_end, canvas);
  canvas->Write("x", x_end + Eigen::Vector2d(6.0, 4.0), kSmallTextPx, kInk);
  canvas->Write("y", y_end + Eigen::Vector2d(7.0, 6.0), kSmallTextPx, kInk);
}

double DrawHeightLegend(const BirdsEyeScene& scene,
                        const Eigen::Vector2d& origin_px,
                        double ramp_height_px,
                        Canvas* canvas) {
  constexpr double kRampWidthPx = 20.0;
  canvas->Write("height [m]", {origin_px.x(), origin_px.y() + kSmallTextPx}, kSmallTextPx, kInk);
  const Eigen::Vector2d low = origin_px + Eigen::Vector2d(0.0, kSmallTextPx + 14.0);
  const Eigen::Vector2d high = low + Eigen::Vector2d(kRampWidthPx, ramp_height_px);
  const int rows = static_cast<int>(ramp_height_px);
  for (int row = 0; row < rows; ++row) {
    canvas->FillBox({low.x(), low.y() + row},
                    {high.x(), low.y() + row + 1.0},
                    HeightColor(1.0 - (row + 0.5) / rows));
  }
  canvas->DrawBox(low, high, kInk);
  const double range_m = scene.highest_m - scene.lowest_m;
  const double step_m = RoundLength(range_m / 3.0);
  const double first = std::ceil(scene.lowest_m / step_m);
  for (int i = 0; (first + i) * step_m <= scene.highest_m; ++i) {
    const double tick_m = (first + i) * step_m;
    const double share = (tick_m - scene.lowest_m) / range_m;
    const double y = std::round(high.y() - share * ramp_height_px);
    canvas->FillBox({high.x(), y - 0.5}, {high.x() + 5.0, y + 0.5}, kInk);
    canvas->Write(Decimal(tick_m), {high.x() + 10.0, y + kSmallTextPx / 2.0}, kSmallTextPx, kInk);
  }
  return high.y();
}

void DrawPathLegend(const std::vector<RobotPath>& paths,
                    const Eigen::Vector2d& origin_px,
                    double width_px,
                    Canvas* canvas) {
  Eigen::Vector2d row_px = origin_px + Eigen::Vector2d(0.0, kMarkRadiusPx + 2.0);
  const auto write = [&row_px, canvas, width_px](const std::string& text) {
    canvas->Write(Fit(text, kSmallTextPx, width_px - kTextOffsetPx),
                  row_px + Eigen::Vector2d(kTextOffsetPx, kSmallTextPx / 2.0),
                  kSmallTextPx,
                  kInk);
    row_px.y() += kLegendRowPx;
  };
  for (std::size_t i = 0; i < std::min(paths.size(), kMaxPathRows); ++i) {
    canvas->DrawStrokes(
        {{row_px, row_px + Eigen::Vector2d(kSampleWidthPx, 0.0)}}, kPathWidthPx, PathColor(i));
    write(paths[i].robot.empty() ? "robot path" : paths[i].robot);
  }
  if (paths.size() > kMaxPathRows) {
    write("and " + std::to_string(paths.size() - kMaxPathRows) + " more");
  }
  DrawStartMark(row_px + Eigen::Vector2d(kSampleWidthPx / 2.0, 0.0), canvas);
  write("start");
  DrawEndMark(row_px + Eigen::Vector2d(kSampleWidthPx / 2.0, 0.0), canvas);
  write("end");
}

std::string Fit(std::string text, double cap_height_px, double width_px) {
  if (TextWidth(text, cap_height_px) <= width_px) return text;
  while (!text.empty() && TextWidth(text + "..", cap_height_px) > width_px) text.pop_back();
  return text + "..";
}

}  // namespace steadymap
