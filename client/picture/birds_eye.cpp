#include "client/picture/birds_eye.h"

#include <algorithm>
#include <cmath>

#include "client/picture/birds_eye_legend.h"
#include "client/picture/birds_eye_objects.h"
#include "client/picture/birds_eye_scene.h"
#include "client/picture/canvas.h"
#include "client/picture/picture_style.h"
#include "client/picture/surface_shading.h"

namespace steadymap {
namespace {

// Minimum size, so that titles and legends fit for every map.
constexpr int kMinMapWidthPx = 400;
constexpr int kMinMapHeightPx = 320;

constexpr double kLegendGapPx = 20.0;

// The position of the map in the picture.
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

// Returns the view of the map's rectangle, centred on the scene.
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

/// Marks drawn on top of the surface.
struct Marks {
  const std::vector<RobotPath>& paths;
  const std::vector<ObjectMark>& objects;
};

// Draws the map's rectangle: grid, surface, objects, paths.
Canvas DrawMap(const Mesh& mesh,
               const Marks& marks,
               const BirdsEyeScene& scene,
               const TopDownView& view,
               bool use_mesh_colors) {
  Canvas map(view.width_px, view.height_px, kWhite);
  DrawGrid(view, RoundLength(view.metres_per_px * 150.0), &map);
  PaintSurface(mesh, scene, view, use_mesh_colors, &map);
  DrawObjects(marks.objects, view, &map);
  DrawPaths(marks.paths, view, &map);
  if (!scene.has_surface) {
    const std::string message = "no surface: the map is empty";
    const Eigen::Vector2d center(view.width_px / 2.0, view.height_px / 2.0);
    map.Write(message, {center.x() - TextWidth(message, 16.0) / 2.0, center.y()}, 16.0, kInk);
  }
  map.DrawBox(Eigen::Vector2d::Zero(), Eigen::Vector2d(view.width_px, view.height_px), kFrame);
  return map;
}

void WriteTitles(const BirdsEyeOptions& options, Canvas* picture) {
  const double width_px = picture->width_px() - 2.0 * kLeftPx;
  const double title_y = 24.0 + kTitlePx;
  picture->Write(Fit(options.title, kTitlePx, width_px), {kLeftPx, title_y}, kTitlePx, kInk);
  picture->Write(Fit(options.subtitle, kSmallTextPx, width_px),
                 {kLeftPx, title_y + 12.0 + kSmallTextPx},
                 kSmallTextPx,
                 kFaintInk);
}

void DrawSideLegends(const Marks& marks,
                     const BirdsEyeScene& scene,
                     const Layout& layout,
                     bool by_height,
                     Canvas* picture) {
  Eigen::Vector2d origin_px(kLeftPx + layout.map_size_px.x() + kLegendGapPx, kTopPx);
  if (scene.has_surface && by_height) {
    const double share = marks.objects.empty() ? 0.5 : 0.25;
    const double ramp_height_px = std::min(240.0, std::floor(layout.map_size_px.y() * share));
    origin_px.y() = DrawHeightLegend(scene, origin_px, ramp_height_px, picture) + kLegendGapPx;
  }
  if (!marks.objects.empty()) {
    origin_px.y() = DrawObjectLegend(marks.objects, origin_px, picture) + kLegendGapPx;
  }
  if (!marks.paths.empty()) {
    DrawPathLegend(marks.paths, origin_px, kRightPx - kLegendGapPx - 8.0, picture);
  }
}

}  // namespace

BirdsEyePicture DrawBirdsEye(const Mesh& mesh,
                             const std::vector<RobotPath>& paths,
                             const BirdsEyeOptions& options) {
  return DrawBirdsEye(mesh, paths, {}, options);
}

BirdsEyePicture DrawBirdsEye(const Mesh& mesh,
                             const std::vector<RobotPath>& paths,
                             const std::vector<ObjectMark>& objects,
                             const BirdsEyeOptions& options) {
  const Marks marks{paths, objects};
  BirdsEyeScene scene = ChooseScene(mesh, paths, options);
  ExtendToObjects(objects, &scene.extent_world);
  const Layout layout = LayOut(scene, std::clamp(options.longest_side_px, 600, 8000));
  const TopDownView map_view = MapView(scene, layout);
  const bool use_mesh_colors = options.use_mesh_colors && !mesh.colors.empty();

  Canvas picture(layout.picture_size_px.x(), layout.picture_size_px.y(), kPage);
  picture.Paste(DrawMap(mesh, marks, scene, map_view, use_mesh_colors),
                layout.map_low_px.x(),
                layout.map_low_px.y());
  WriteTitles(options, &picture);
  DrawSideLegends(marks, scene, layout, !use_mesh_colors, &picture);

  BirdsEyePicture result;
  const double bottom_px = kTopPx + layout.map_size_px.y();
  result.scale_bar_m = RoundLength(layout.map_size_px.x() * layout.metres_per_px * 0.3);
  result.scale_bar_px = {kLeftPx, static_cast<int>(bottom_px) + 22};
  DrawScaleBar(result.scale_bar_m, layout.metres_per_px, result.scale_bar_px, &picture);
  DrawAxes({kLeftPx + layout.map_size_px.x() - 60.0, bottom_px + 56.0}, &picture);
  if (std::isfinite(scene.cut_height_m)) {
    result.cut_height_m = scene.cut_height_m;
    picture.WriteRightAligned(
        "surface above " + Decimal(std::round(scene.cut_height_m * 10.0) / 10.0) + " m omitted",
        {kLeftPx + layout.map_size_px.x() - 90.0, bottom_px + 56.0},
        kSmallTextPx,
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
