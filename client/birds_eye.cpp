#include "client/birds_eye.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "client/birds_eye_legend.h"
#include "client/birds_eye_scene.h"
#include "client/canvas.h"
#include "client/height_ramp.h"

namespace steadymap {
namespace {

constexpr Rgb kPage = {247, 247, 245};
constexpr Rgb kInk = {45, 48, 54};
constexpr Rgb kFaintInk = {105, 110, 118};
constexpr Rgb kFrame = {150, 154, 160};
constexpr Rgb kWhite = {255, 255, 255};

// Margins around the map, pixels.
constexpr int kLeftPx = 28;
constexpr int kTopPx = 84;
constexpr int kRightPx = 172;
constexpr int kBottomPx = 78;
// Room that titles and legends need whatever the map's shape.
constexpr int kMinMapWidthPx = 400;
constexpr int kMinMapHeightPx = 320;

constexpr double kTitlePx = 19.0;
constexpr double kSubtitlePx = 11.0;
constexpr double kGapPx = 20.0;

// The surface is drawn this much larger and averaged down.
constexpr int kOversampling = 2;

// How much a pixel darkens for every metre that its surroundings stand above it, averaged over the
// neighbours at this distance; a neighbour counts at most kMaxStepM.
constexpr int kNeighbourPx = 3;
constexpr double kDarkeningPerM = 1.6;
constexpr double kMaxStepM = 0.6;

// Light that reaches a surface turned away from the lamp.
constexpr double kAmbientLight = 0.62;

// Where the map lies in the picture.
struct Layout {
  Eigen::Vector2i map_low_px;  // Top left corner.
  Eigen::Vector2i map_size_px;
  Eigen::Vector2i picture_size_px;
  double metres_per_px;
};

Layout LayOut(const BirdsEyeScene& scene, int longest_side_px) {
  const Eigen::Vector2d extent_m = scene.extent_world.sizes();
  const Eigen::Vector2d available_px(longest_side_px - kLeftPx - kRightPx,
                                     longest_side_px - kTopPx - kBottomPx);
  Layout layout;
  layout.metres_per_px = extent_m.cwiseQuotient(available_px).maxCoeff();
  const Eigen::Vector2d needed_px = extent_m / layout.metres_per_px;
  layout.map_low_px = {kLeftPx, kTopPx};
  layout.map_size_px = {std::max(kMinMapWidthPx, static_cast<int>(std::lround(needed_px.x()))),
                        std::max(kMinMapHeightPx, static_cast<int>(std::lround(needed_px.y())))};
  layout.picture_size_px =
      layout.map_size_px + Eigen::Vector2i(kLeftPx + kRightPx, kTopPx + kBottomPx);
  return layout;
}

// The view of the map's rectangle alone, its centre on the scene's.
TopDownView MapView(const BirdsEyeScene& scene, const Layout& layout) {
  TopDownView view;
  view.metres_per_px = layout.metres_per_px;
  view.width_px = layout.map_size_px.x();
  view.height_px = layout.map_size_px.y();
  const Eigen::Vector2d half_m = layout.map_size_px.cast<double>() * layout.metres_per_px / 2.0;
  const Eigen::Vector2d center_world = scene.extent_world.center();
  view.top_left_world = {center_world.x() - half_m.x(), center_world.y() + half_m.y()};
  return view;
}

// Share of its light that a pixel keeps among its neighbours: what stands beside something tall
// lies in its shade, which is what makes steps in height visible from above.
double Openness(const TopDownRaster& raster, int u, int v) {
  static constexpr std::array<std::array<int, 2>, 8> kDirections = {
      {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}}};
  const double own_m = static_cast<double>(raster.height_m.At(u, v));
  double above_m = 0.0;
  for (const auto& [du, dv] : kDirections) {
    const int side_u = std::clamp(u + du * kNeighbourPx, 0, raster.height_m.width_px() - 1);
    const int side_v = std::clamp(v + dv * kNeighbourPx, 0, raster.height_m.height_px() - 1);
    const double step_m = static_cast<double>(raster.height_m.At(side_u, side_v)) - own_m;
    above_m += std::clamp(step_m, 0.0, kMaxStepM);
  }
  return std::exp(-kDarkeningPerM * above_m / static_cast<double>(kDirections.size()));
}

Eigen::Vector3d ShadedColor(const TopDownRaster& raster, const BirdsEyeScene& scene, int u, int v) {
  const double height_m = static_cast<double>(raster.height_m.At(u, v));
  const Rgb base =
      raster.color.empty()
          ? HeightColor((height_m - scene.lowest_m) / (scene.highest_m - scene.lowest_m))
          : raster.color.At(u, v);
  // A level floor keeps its colour; slopes towards the lamp get a little more.
  const double light =
      kAmbientLight + (1.0 - kAmbientLight) * static_cast<double>(raster.light.At(u, v)) * 1.25;
  return Eigen::Vector3d(base[0], base[1], base[2]) * light * Openness(raster, u, v);
}

void PaintSurface(const TopDownRaster& raster,
                  const BirdsEyeScene& scene,
                  const TopDownView& view,
                  Canvas* map) {
  for (int v = 0; v < view.height_px; ++v) {
    for (int u = 0; u < view.width_px; ++u) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      int hits = 0;
      for (int i = 0; i < kOversampling * kOversampling; ++i) {
        const int fine_u = u * kOversampling + i % kOversampling;
        const int fine_v = v * kOversampling + i / kOversampling;
        if (raster.height_m.At(fine_u, fine_v) == TopDownRaster::kNothing) continue;
        sum += ShadedColor(raster, scene, fine_u, fine_v);
        ++hits;
      }
      if (hits == 0) continue;
      const Eigen::Vector3d mean = (sum / hits).cwiseMin(255.0);
      const Rgb color = {static_cast<std::uint8_t>(mean.x()),
                         static_cast<std::uint8_t>(mean.y()),
                         static_cast<std::uint8_t>(mean.z())};
      map->Blend(u, v, color, static_cast<double>(hits) / (kOversampling * kOversampling));
    }
  }
}

// The map's rectangle: grid, surface, paths.
Canvas DrawMap(const Mesh& mesh,
               const std::vector<RobotPath>& paths,
               const BirdsEyeScene& scene,
               const TopDownView& view,
               bool use_mesh_colors) {
  Canvas map(view.width_px, view.height_px, kWhite);
  DrawGrid(view, RoundLength(view.metres_per_px * 150.0), &map);
  TopDownView fine_view = view;
  fine_view.metres_per_px /= kOversampling;
  fine_view.width_px *= kOversampling;
  fine_view.height_px *= kOversampling;
  TopDownRaster raster = DrawTopDown(mesh, fine_view, scene.cut_height_m, kOversampling + 1);
  if (!use_mesh_colors) raster.color = {};
  PaintSurface(raster, scene, view, &map);
  DrawPaths(paths, view, &map);
  if (!scene.has_surface) {
    const std::string message = "no surface: the map is empty";
    const Eigen::Vector2d center(view.width_px / 2.0, view.height_px / 2.0);
    map.Write(message, {center.x() - TextWidth(message, 16.0) / 2.0, center.y()}, 16.0, kInk);
  }
  map.DrawBox(Eigen::Vector2d::Zero(), Eigen::Vector2d(view.width_px, view.height_px), kFrame);
  return map;
}

void Paste(const Canvas& map, const Eigen::Vector2i& low_px, Canvas* picture) {
  for (int v = 0; v < map.height_px(); ++v) {
    for (int u = 0; u < map.width_px(); ++u) {
      picture->Blend(low_px.x() + u, low_px.y() + v, map.image().At(u, v), 1.0);
    }
  }
}

void WriteTitles(const BirdsEyeOptions& options, Canvas* picture) {
  const double width_px = picture->width_px() - 2.0 * kLeftPx;
  const double title_y = 24.0 + kTitlePx;
  picture->Write(Fit(options.title, kTitlePx, width_px), {kLeftPx, title_y}, kTitlePx, kInk);
  picture->Write(Fit(options.subtitle, kSubtitlePx, width_px),
                 {kLeftPx, title_y + 12.0 + kSubtitlePx},
                 kSubtitlePx,
                 kFaintInk);
}

void DrawSideLegends(const std::vector<RobotPath>& paths,
                     const BirdsEyeScene& scene,
                     const Layout& layout,
                     bool by_height,
                     Canvas* picture) {
  Eigen::Vector2d origin_px(kLeftPx + layout.map_size_px.x() + kGapPx, kTopPx);
  if (scene.has_surface && by_height) {
    const double ramp_height_px = std::min(240.0, layout.map_size_px.y() * 0.5);
    origin_px.y() = DrawHeightLegend(scene, origin_px, ramp_height_px, picture) + kGapPx;
  }
  if (!paths.empty()) DrawPathLegend(paths, origin_px, kRightPx - kGapPx - 8.0, picture);
}

}  // namespace

BirdsEyePicture DrawBirdsEye(const Mesh& mesh,
                             const std::vector<RobotPath>& paths,
                             const BirdsEyeOptions& options) {
  const BirdsEyeScene scene = ChooseScene(mesh, paths, options);
  const Layout layout = LayOut(scene, std::clamp(options.longest_side_px, 600, 8000));
  const TopDownView map_view = MapView(scene, layout);
  const bool use_mesh_colors = options.use_mesh_colors && !mesh.colors.empty();

  Canvas picture(layout.picture_size_px.x(), layout.picture_size_px.y(), kPage);
  Paste(DrawMap(mesh, paths, scene, map_view, use_mesh_colors), layout.map_low_px, &picture);
  WriteTitles(options, &picture);
  DrawSideLegends(paths, scene, layout, !use_mesh_colors, &picture);

  BirdsEyePicture result;
  const double bottom_px = kTopPx + layout.map_size_px.y();
  result.scale_bar_m = RoundLength(layout.map_size_px.x() * layout.metres_per_px * 0.3);
  result.scale_bar_px = {kLeftPx, static_cast<int>(bottom_px) + 22};
  DrawScaleBar(result.scale_bar_m, layout.metres_per_px, result.scale_bar_px, &picture);
  DrawAxes({kLeftPx + layout.map_size_px.x() - 60.0, bottom_px + 56.0}, &picture);
  if (std::isfinite(scene.cut_height_m)) {
    result.cut_height_m = scene.cut_height_m;
    picture.WriteRightAligned(
        "without what is above " + Decimal(std::round(scene.cut_height_m * 10.0) / 10.0) + " m",
        {kLeftPx + layout.map_size_px.x() - 90.0, bottom_px + 56.0},
        kSubtitlePx,
        kFaintInk);
  }
  result.image = picture.image();
  result.view = map_view;
  result.view.width_px = picture.width_px();
  result.view.height_px = picture.height_px();
  result.view.top_left_world += Eigen::Vector2d(-kLeftPx, kTopPx) * layout.metres_per_px;
  return result;
}

}  // namespace steadymap
