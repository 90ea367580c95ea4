#include "client/picture/top_down_raster.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>

namespace steadymap {
namespace {

// Surface less than 30 degrees off the vertical counts as a wall.
constexpr float kSteepCosine = 0.5F;

const Eigen::Vector3f kTowardsLamp = Eigen::Vector3f(-0.45F, 0.55F, 0.70F).normalized();

// Values at a corner of a triangle; they are interpolated linearly in between.
struct Corner {
  Eigen::Vector2f position_px;
  float height_m;
  float light;
  Eigen::Vector3f color;
};

class Painter {
 public:
  Painter(const Mesh& mesh, const TopDownView& view, int line_px)
      : mesh_(mesh), view_(view), line_px_(line_px) {
    raster_.height_m = Image<float>(view.width_px, view.height_px, TopDownRaster::kNothing);
    raster_.light = Image<float>(view.width_px, view.height_px);
    if (!mesh.colors.empty()) raster_.color = Image<Rgb>(view.width_px, view.height_px);
  }

  void Paint(const std::array<std::uint32_t, 3>& triangle) {
    std::array<Corner, 3> corners;
    for (std::size_t i = 0; i < 3; ++i) corners[i] = CornerOf(triangle[i]);
    FillTriangle(corners);
    if (std::abs(UpwardCosine(mesh_, triangle)) >= kSteepCosine) return;
    for (std::size_t i = 0; i < 3; ++i) DrawEdge(corners[i], corners[(i + 1) % 3]);
  }

  TopDownRaster Take() { return std::move(raster_); }

 private:
  Corner CornerOf(std::uint32_t vertex) const {
    const Eigen::Vector3f& position_world = mesh_.vertices_world[vertex];
    Corner corner;
    corner.position_px = view_.PixelOf(position_world.head<2>().cast<double>()).cast<float>();
    corner.height_m = position_world.z();
    corner.light = std::max(0.0F, mesh_.normals_world[vertex].dot(kTowardsLamp));
    corner.color.setZero();
    if (!mesh_.colors.empty()) {
      const Rgb& rgb = mesh_.colors[vertex];
      // Adds half a step so that the later truncation rounds.
      corner.color = Eigen::Vector3f(rgb[0], rgb[1], rgb[2]).array() + 0.5F;
    }
    return corner;
  }

  // Writes a surface point to the pixel (`u`, `v`) unless the pixel holds a higher one.
  void Put(int u, int v, const Corner& point) {
    if (u < 0 || v < 0 || u >= view_.width_px || v >= view_.height_px) return;
    float& height_m = raster_.height_m.At(u, v);
    if (point.height_m < height_m) return;
    height_m = point.height_m;
    raster_.light.At(u, v) = point.light;
    if (raster_.color.empty()) return;
    Rgb& color = raster_.color.At(u, v);
    for (std::size_t i = 0; i < 3; ++i) {
      color[i] = static_cast<std::uint8_t>(point.color[static_cast<Eigen::Index>(i)]);
    }
  }

  static Corner Between(const std::array<Corner, 3>& corners, const Eigen::Vector3f& weights) {
    Corner point;
    point.height_m = 0.0F;
    point.light = 0.0F;
    point.color.setZero();
    for (std::size_t i = 0; i < 3; ++i) {
      const float weight = weights[static_cast<Eigen::Index>(i)];
      point.height_m += weight * corners[i].height_m;
      point.light += weight * corners[i].light;
      point.color += weight * corners[i].color;
    }
    return point;
  }

  // Fills the pixels with centres inside the triangle's projection.
  void FillTriangle(const std::array<Corner, 3>& corners) {
    const Eigen::Vector2f& a = corners[0].position_px;
    const Eigen::Vector2f ab = corners[1].position_px - a;
    const Eigen::Vector2f ac = corners[2].position_px - a;
    const float doubled_area = ab.x() * ac.y() - ab.y() * ac.x();
    if (doubled_area == 0.0F) return;
    const Eigen::Vector2f size(static_cast<float>(view_.width_px),
                               static_cast<float>(view_.height_px));
    const Eigen::Vector2f low =
        a.cwiseMin(a + ab).cwiseMin(a + ac).cwiseMax(Eigen::Vector2f::Zero());
    const Eigen::Vector2f high = a.cwiseMax(a + ab).cwiseMax(a + ac).cwiseMin(size);
    if (low.x() >= high.x() || low.y() >= high.y()) return;
    for (int v = static_cast<int>(low.y()); v < static_cast<int>(std::ceil(high.y())); ++v) {
      for (int u = static_cast<int>(low.x()); u < static_cast<int>(std::ceil(high.x())); ++u) {
        const Eigen::Vector2f ap =
            Eigen::Vector2f(static_cast<float>(u) + 0.5F, static_cast<float>(v) + 0.5F) - a;
        const float weight_b = (ap.x() * ac.y() - ap.y() * ac.x()) / doubled_area;
        const float weight_c = (ab.x() * ap.y() - ab.y() * ap.x()) / doubled_area;
        const Eigen::Vector3f weights(1.0F - weight_b - weight_c, weight_b, weight_c);
        if (weights.minCoeff() >= 0.0F) Put(u, v, Between(corners, weights));
      }
    }
  }

  void DrawEdge(const Corner& from, const Corner& to) {
    const Eigen::Vector2f along_px = to.position_px - from.position_px;
    const float length_px = along_px.cwiseAbs().maxCoeff();
    // An edge longer than the picture cannot come from observed surface.
    if (!(length_px <= static_cast<float>(view_.width_px + view_.height_px))) return;
    const int steps = std::max(1, static_cast<int>(std::ceil(length_px)));
    for (int step = 0; step <= steps; ++step) {
      const float share = static_cast<float>(step) / static_cast<float>(steps);
      const Corner point = Between({from, to, to}, Eigen::Vector3f(1.0F - share, share, 0.0F));
      const Eigen::Vector2f low_px = from.position_px + share * along_px -
                                     Eigen::Vector2f::Constant(0.5F * static_cast<float>(line_px_));
      const int u = static_cast<int>(std::lround(low_px.x()));
      const int v = static_cast<int>(std::lround(low_px.y()));
      for (int i = 0; i < line_px_ * line_px_; ++i) Put(u + i % line_px_, v + i / line_px_, point);
    }
  }

  const Mesh& mesh_;
  const TopDownView& view_;
  const int line_px_;
  TopDownRaster raster_;
};

}  // namespace

float UpwardCosine(const Mesh& mesh, const std::array<std::uint32_t, 3>& triangle) {
  const Eigen::Vector3f& a = mesh.vertices_world[triangle[0]];
  const Eigen::Vector3f normal =
      (mesh.vertices_world[triangle[1]] - a).cross(mesh.vertices_world[triangle[2]] - a);
  const float length = normal.norm();
  return length > 0.0F ? normal.z() / length : 0.0F;
}

bool IsDrawnTopDown(const Mesh& mesh,
                    const std::array<std::uint32_t, 3>& triangle,
                    double cut_height_m) {
  for (const std::uint32_t vertex : triangle) {
    const Eigen::Vector3f& position_world = mesh.vertices_world[vertex];
    if (!position_world.allFinite() || static_cast<double>(position_world.z()) > cut_height_m)
      return false;
  }
  return UpwardCosine(mesh, triangle) > -kSteepCosine;
}

TopDownRaster DrawTopDown(const Mesh& mesh,
                          const TopDownView& view,
                          double cut_height_m,
                          int line_px) {
  Painter painter(mesh, view, line_px);
  for (const std::array<std::uint32_t, 3>& triangle : mesh.triangles) {
    if (IsDrawnTopDown(mesh, triangle, cut_height_m)) painter.Paint(triangle);
  }
  return painter.Take();
}

}  // namespace steadymap
