#include "client/bench/evaluation/report/score_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include "client/picture/birds_eye_legend.h"
#include "client/picture/canvas.h"
#include "client/picture/picture_style.h"

namespace steadymap {
namespace {

struct VerdictStyle {
  const char* name;
  Rgb color;
};

// In the order of VoxelVerdict. Distinguishable with any kind of colour vision.
constexpr std::array<VerdictStyle, 3> kStyles = {
    {{"true", {70, 125, 105}}, {"wrong", {213, 80, 0}}, {"missed", {60, 130, 235}}}};

// Sizes within the picture, pixels.
constexpr int kMapSidePx = 900;
constexpr int kMinMapSidePx = 320;
constexpr double kRowPx = 24.0;

// This many voxels in a column get the full colour.
constexpr double kFullColumn = 4.0;

using Counts = std::array<std::size_t, kStyles.size()>;
using Columns = std::map<std::pair<std::int32_t, std::int32_t>, Counts>;

Columns StackUp(const std::vector<JudgedVoxel>& voxels) {
  Columns columns;
  for (const JudgedVoxel& judged : voxels) {
    ++columns[{judged.voxel.x, judged.voxel.y}][static_cast<std::size_t>(judged.verdict)];
  }
  return columns;
}

// Returns the verdict of a column: the last of the largest counts.
std::size_t VerdictOf(const Counts& counts) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < counts.size(); ++i) {
    if (counts[i] > 0 && counts[i] >= counts[best]) best = i;
  }
  return best;
}

// Returns the view of all columns with a margin of two, with whole pixels per voxel.
TopDownView ViewOf(const Columns& columns, double voxel_size_m) {
  Eigen::AlignedBox2i cells;
  for (const auto& [cell, counts] : columns) cells.extend(Eigen::Vector2i(cell.first, cell.second));
  if (cells.isEmpty()) cells.extend(Eigen::Vector2i::Zero());
  cells.min() -= Eigen::Vector2i::Constant(2);
  cells.max() += Eigen::Vector2i::Constant(2);
  const Eigen::Vector2i size = cells.sizes() + Eigen::Vector2i::Ones();
  const int pixels_a_voxel = std::clamp(kMapSidePx / size.maxCoeff(), 1, 24);
  TopDownView view;
  view.metres_per_px = voxel_size_m / pixels_a_voxel;
  view.width_px = std::max(kMinMapSidePx, size.x() * pixels_a_voxel);
  view.height_px = std::max(kMinMapSidePx, size.y() * pixels_a_voxel);
  view.top_left_world =
      Eigen::Vector2d(cells.min().x() - 0.5, cells.max().y() + 0.5) * voxel_size_m;
  return view;
}

Canvas DrawColumns(const Columns& columns, double voxel_size_m, const TopDownView& view) {
  Canvas map(view.width_px, view.height_px, kWhite);
  DrawGrid(view, RoundLength(view.metres_per_px * 150.0), &map);
  for (const auto& [cell, counts] : columns) {
    const std::size_t verdict = VerdictOf(counts);
    const double share = std::min(1.0, static_cast<double>(counts[verdict]) / kFullColumn);
    const Eigen::Vector2d low(cell.first - 0.5, cell.second + 0.5);
    const Eigen::Vector2d high(cell.first + 0.5, cell.second - 0.5);
    map.FillBox(view.PixelOf(low * voxel_size_m),
                view.PixelOf(high * voxel_size_m),
                Mix(kWhite, kStyles[verdict].color, 0.35 + 0.65 * share));
  }
  if (columns.empty()) map.Write("nothing was scored", {24.0, 40.0}, 16.0, kInk);
  map.DrawBox(Eigen::Vector2d::Zero(), Eigen::Vector2d(view.width_px, view.height_px), kFrame);
  return map;
}

void DrawLegend(const std::vector<JudgedVoxel>& voxels,
                const Eigen::Vector2d& origin_px,
                Canvas* canvas) {
  Counts counts{};
  for (const JudgedVoxel& judged : voxels) ++counts[static_cast<std::size_t>(judged.verdict)];
  canvas->Write("voxels", {origin_px.x(), origin_px.y() + kSmallTextPx}, kSmallTextPx, kInk);
  Eigen::Vector2d row_px = origin_px + Eigen::Vector2d(0.0, kRowPx);
  for (std::size_t i = 0; i < kStyles.size(); ++i) {
    canvas->FillBox(row_px, row_px + Eigen::Vector2d(16.0, 16.0), kStyles[i].color);
    canvas->Write(std::string(kStyles[i].name) + " " + std::to_string(counts[i]),
                  row_px + Eigen::Vector2d(26.0, 13.0),
                  kSmallTextPx,
                  kInk);
    row_px.y() += kRowPx;
  }
}

}  // namespace

Image<Rgb> DrawScorePicture(const std::vector<JudgedVoxel>& voxels,
                            double voxel_size_m,
                            const ScorePictureText& text) {
  const Columns columns = StackUp(voxels);
  const TopDownView view = ViewOf(columns, voxel_size_m);
  const Canvas map = DrawColumns(columns, voxel_size_m, view);
  Canvas picture(kLeftPx + view.width_px + kRightPx, kTopPx + view.height_px + kBottomPx, kPage);
  picture.Paste(map, kLeftPx, kTopPx);
  const double width_px = picture.width_px() - 2.0 * kLeftPx;
  picture.Write(Fit(text.title, kTitlePx, width_px), {kLeftPx, 24.0 + kTitlePx}, kTitlePx, kInk);
  picture.Write(Fit(text.subtitle, kSmallTextPx, width_px),
                {kLeftPx, 36.0 + kTitlePx + kSmallTextPx},
                kSmallTextPx,
                kFaintInk);
  DrawLegend(voxels, Eigen::Vector2d(kLeftPx + view.width_px + 20.0, kTopPx), &picture);
  const double bottom_px = kTopPx + view.height_px;
  DrawScaleBar(RoundLength(view.width_px * view.metres_per_px * 0.3),
               view.metres_per_px,
               {kLeftPx, static_cast<int>(bottom_px) + 22},
               &picture);
  DrawAxes({kLeftPx + view.width_px - 60.0, bottom_px + 56.0}, &picture);
  return picture.image();
}

}  // namespace steadymap
