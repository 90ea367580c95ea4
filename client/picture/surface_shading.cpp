#include "client/picture/surface_shading.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "client/picture/height_ramp.h"

namespace steadymap {
namespace {

// The surface is drawn at this multiple of the resolution and averaged down.
constexpr int kOversampling = 2;

// Darkening per metre that the neighbours at distance kNeighbourPx are higher than a pixel,
// averaged over the neighbours; each contributes at most kMaxStepM.
constexpr int kNeighbourPx = 3;
constexpr double kDarkeningPerM = 1.6;
constexpr double kMaxStepM = 0.6;

// Light on a surface facing away from the lamp, and additional light on a surface facing it. With
// both, a level floor keeps about its own colour.
constexpr double kAmbientLight = 0.62;
constexpr double kDirectLight = 0.475;

// Returns the share of light that a pixel receives. Surface beside a taller object is shaded, which
// makes steps in height visible from above.
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
  if (above_m == 0.0) return 1.0;
  return std::exp(-kDarkeningPerM * above_m / static_cast<double>(kDirections.size()));
}

// The height ramp as a table: one look-up per pixel instead of a colour-space conversion.
class HeightTable {
 public:
  HeightTable() {
    for (std::size_t i = 0; i < kSteps; ++i) {
      colors_[i] = HeightColor(static_cast<double>(i) / (kSteps - 1));
    }
  }

  const Rgb& At(double share) const {
    return colors_[static_cast<std::size_t>(
        std::lround(std::clamp(share, 0.0, 1.0) * (kSteps - 1)))];
  }

 private:
  static constexpr std::size_t kSteps = 512;
  std::array<Rgb, kSteps> colors_{};
};

Eigen::Vector3d ShadedColor(const TopDownRaster& raster,
                            const BirdsEyeScene& scene,
                            const HeightTable& heights,
                            int u,
                            int v) {
  const double height_m = static_cast<double>(raster.height_m.At(u, v));
  const Rgb& base =
      raster.color.empty()
          ? heights.At((height_m - scene.lowest_m) / (scene.highest_m - scene.lowest_m))
          : raster.color.At(u, v);
  const double light = kAmbientLight + kDirectLight * static_cast<double>(raster.light.At(u, v));
  return Eigen::Vector3d(base[0], base[1], base[2]) * light * Openness(raster, u, v);
}

}  // namespace

void PaintSurface(const Mesh& mesh,
                  const BirdsEyeScene& scene,
                  const TopDownView& view,
                  bool use_mesh_colors,
                  Canvas* map) {
  TopDownView fine_view = view;
  fine_view.metres_per_px /= kOversampling;
  fine_view.width_px *= kOversampling;
  fine_view.height_px *= kOversampling;
  TopDownRaster raster = DrawTopDown(mesh, fine_view, scene.cut_height_m, kOversampling + 1);
  if (!use_mesh_colors) raster.color = {};
  const HeightTable heights;
  for (int v = 0; v < view.height_px; ++v) {
    for (int u = 0; u < view.width_px; ++u) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      int hits = 0;
      for (int i = 0; i < kOversampling * kOversampling; ++i) {
        const int fine_u = u * kOversampling + i % kOversampling;
        const int fine_v = v * kOversampling + i / kOversampling;
        if (raster.height_m.At(fine_u, fine_v) == TopDownRaster::kNothing) continue;
        sum += ShadedColor(raster, scene, heights, fine_u, fine_v);
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

}  // namespace steadymap
