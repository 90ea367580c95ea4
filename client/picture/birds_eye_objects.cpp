#include "client/picture/birds_eye_objects.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "client/picture/picture_style.h"

namespace steadymap {
namespace {

constexpr Rgb kGone = {213, 94, 0};
constexpr Rgb kUnsure = {240, 205, 120};
constexpr Rgb kStays = {0, 84, 166};
constexpr Rgb kGhost = {70, 70, 70};

constexpr double kOutlinePx = 3.0;
constexpr double kCasingPx = 5.5;
constexpr double kGhostPx = 1.6;
constexpr double kDashPx = 7.0;
constexpr double kDashGapPx = 5.0;

bool IsFinite(const ObjectMark& object) {
  return object.cuboid.center_world.allFinite() && object.cuboid.size_m.allFinite() &&
         std::isfinite(object.cuboid.yaw_rad);
}

// Returns the closed outline as seen from above.
Stroke OutlineOf(const Cuboid& cuboid, const TopDownView& view) {
  Stroke outline;
  for (const Eigen::Vector2d& corner_world : cuboid.BaseCorners()) {
    outline.push_back(view.PixelOf(corner_world));
  }
  outline.push_back(outline.front());
  return outline;
}

// Returns the dashes of a line; the pattern restarts at every corner. A segment far longer than any
// view stays undivided, which bounds the cost.
std::vector<Stroke> Dashes(const Stroke& line) {
  constexpr double kMaxLengthPx = 10'000.0;
  std::vector<Stroke> dashes;
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const Eigen::Vector2d way = line[i + 1] - line[i];
    const double length_px = way.norm();
    if (length_px > kMaxLengthPx) {
      dashes.push_back({line[i], line[i + 1]});
      continue;
    }
    const int count = static_cast<int>(length_px / (kDashPx + kDashGapPx)) + 1;
    for (int dash = 0; dash < count; ++dash) {
      const double from = std::min(1.0, dash * (kDashPx + kDashGapPx) / std::max(length_px, 1.0));
      const double to = std::min(1.0, from + kDashPx / std::max(length_px, 1.0));
      dashes.push_back({line[i] + from * way, line[i] + to * way});
    }
  }
  return dashes;
}

}  // namespace

Rgb StationarityColor(double stationarity) {
  const double share = std::clamp(stationarity, 0.0, 1.0);
  if (share < 0.5) return Mix(kGone, kUnsure, 2.0 * share);
  return Mix(kUnsure, kStays, 2.0 * share - 1.0);
}

void ExtendToObjects(const std::vector<ObjectMark>& objects, Eigen::AlignedBox2d* extent_world) {
  // Space for the outline itself.
  constexpr double kMarginM = 0.05;
  for (const ObjectMark& object : objects) {
    if (!IsFinite(object)) continue;
    for (const Eigen::Vector2d& corner_world : object.cuboid.BaseCorners()) {
      extent_world->extend(Eigen::Vector2d(corner_world.array() - kMarginM));
      extent_world->extend(Eigen::Vector2d(corner_world.array() + kMarginM));
    }
  }
}

void DrawObjects(const std::vector<ObjectMark>& objects, const TopDownView& view, Canvas* canvas) {
  std::vector<const ObjectMark*> ordered;
  for (const ObjectMark& object : objects) {
    if (IsFinite(object)) ordered.push_back(&object);
  }
  std::stable_sort(ordered.begin(), ordered.end(), [](const ObjectMark* a, const ObjectMark* b) {
    if (a->is_ghost != b->is_ghost) return a->is_ghost;
    return a->cuboid.highest_m() < b->cuboid.highest_m();
  });
  for (const ObjectMark* object : ordered) {
    const Stroke outline = OutlineOf(object->cuboid, view);
    if (object->is_ghost) {
      canvas->DrawStrokes(Dashes(outline), kGhostPx, kGhost);
      continue;
    }
    canvas->DrawStrokes({outline}, kCasingPx, kWhite);
    canvas->DrawStrokes({outline}, kOutlinePx, StationarityColor(object->stationarity));
  }
}

double DrawObjectLegend(const std::vector<ObjectMark>& objects,
                        const Eigen::Vector2d& origin_px,
                        Canvas* canvas) {
  constexpr double kRampWidthPx = 96.0;
  constexpr double kRampHeightPx = 12.0;
  double y = origin_px.y() + kSmallTextPx;
  canvas->Write("objects: E[v]", {origin_px.x(), y}, kSmallTextPx, kInk);
  const Eigen::Vector2d low(origin_px.x(), y + 10.0);
  const Eigen::Vector2d high = low + Eigen::Vector2d(kRampWidthPx, kRampHeightPx);
  for (int column = 0; column < static_cast<int>(kRampWidthPx); ++column) {
    canvas->FillBox({low.x() + column, low.y()},
                    {low.x() + column + 1.0, high.y()},
                    StationarityColor((column + 0.5) / kRampWidthPx));
  }
  canvas->DrawBox(low, high, kInk);
  y = high.y() + 8.0 + kSmallTextPx;
  canvas->Write("0", {low.x(), y}, kSmallTextPx, kInk);
  canvas->WriteRightAligned("1", {high.x(), y}, kSmallTextPx, kInk);
  if (std::none_of(objects.begin(), objects.end(), [](const ObjectMark& object) {
        return object.is_ghost;
      })) {
    return y;
  }
  y += kLegendRowPx;
  const Eigen::Vector2d start(origin_px.x(), y - kSmallTextPx / 2.0);
  canvas->DrawStrokes(Dashes({start, start + Eigen::Vector2d(30.0, 0.0)}), kGhostPx, kGhost);
  canvas->Write("removed", {origin_px.x() + 36.0, y}, kSmallTextPx, kInk);
  return y;
}

}  // namespace steadymap
