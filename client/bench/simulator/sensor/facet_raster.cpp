#include "client/bench/simulator/sensor/facet_raster.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace steadymap {
namespace {

// A plane this close to the camera's centre is seen edge-on.
constexpr double kMinPlaneDistanceM = 1e-9;

// Vertices nearer than this do not bound the rows of a facet.
constexpr double kMinProjectedDepthM = 1e-6;

// A linear function of the pixel: `per_u * u + per_v * v + constant`.
struct PixelPlane {
  double per_u = 0.0;
  double per_v = 0.0;
  double constant = 0.0;
};

// Returns `direction . ray(u, v)` as a function of the pixel.
PixelPlane AlongRays(const Eigen::Vector3d& direction, const PinholeCamera& camera) {
  const double per_u = direction.x() / camera.fx;
  const double per_v = direction.y() / camera.fy;
  return {per_u, per_v, direction.z() - per_u * camera.cx - per_v * camera.cy};
}

struct Span {
  int begin = 0;
  int end = 0;
};

// Returns the rows that the facet can touch.
Span RowsOf(const Facet& facet, const PinholeCamera& camera) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (int i = 0; i < facet.vertex_count; ++i) {
    const Eigen::Vector3d& vertex = facet.vertices[static_cast<std::size_t>(i)];
    if (vertex.z() < kMinProjectedDepthM) return {0, camera.height_px};
    const double v = camera.fy * vertex.y() / vertex.z() + camera.cy;
    low = std::min(low, v);
    high = std::max(high, v);
  }
  // Adds one pixel for the rounding of the projection; the edges decide exactly.
  low = std::clamp(std::ceil(low) - 1, 0.0, static_cast<double>(camera.height_px));
  high = std::clamp(std::floor(high) + 2, 0.0, static_cast<double>(camera.height_px));
  return {static_cast<int>(low), static_cast<int>(high)};
}

// The edges of a facet as half-planes of the image, grouped by their bound on a row.
struct Edges {
  std::array<PixelPlane, 4> left;   // u >= per_v * v + constant
  std::array<PixelPlane, 4> right;  // u <= per_v * v + constant
  std::array<PixelPlane, 4> level;  // per_v * v + constant >= 0
  std::size_t left_count = 0;
  std::size_t right_count = 0;
  std::size_t level_count = 0;
};

Edges EdgesOf(const CameraFacet& facet, const PinholeCamera& camera) {
  Edges edges;
  const Facet& outline = facet.facet_camera;
  for (int i = 0; i < outline.vertex_count; ++i) {
    const Eigen::Vector3d& from = outline.vertices[static_cast<std::size_t>(i)];
    const Eigen::Vector3d& to =
        outline.vertices[static_cast<std::size_t>((i + 1) % outline.vertex_count)];
    PixelPlane inside = AlongRays(from.cross(to), camera);
    if (facet.plane_distance_m < 0) {
      inside = {-inside.per_u, -inside.per_v, -inside.constant};
    }
    if (inside.per_u == 0.0) {
      edges.level[edges.level_count++] = inside;
      continue;
    }
    // Both facets of a shared edge compute identical quotients, so no ray passes between them.
    const PixelPlane border = {0.0, -inside.per_v / inside.per_u, -inside.constant / inside.per_u};
    if (inside.per_u > 0) {
      edges.left[edges.left_count++] = border;
    } else {
      edges.right[edges.right_count++] = border;
    }
  }
  return edges;
}

Span ColumnsOf(const Edges& edges, double v, int width_px) {
  for (std::size_t i = 0; i < edges.level_count; ++i) {
    if (edges.level[i].per_v * v + edges.level[i].constant < 0) return {};
  }
  double low = 0.0;
  double high = width_px - 1;
  for (std::size_t i = 0; i < edges.left_count; ++i) {
    low = std::max(low, edges.left[i].per_v * v + edges.left[i].constant);
  }
  for (std::size_t i = 0; i < edges.right_count; ++i) {
    high = std::min(high, edges.right[i].per_v * v + edges.right[i].constant);
  }
  if (!(low <= high)) return {};
  return {static_cast<int>(std::ceil(low)), static_cast<int>(std::floor(high)) + 1};
}

// The inner loop of the renderer: plain arrays and no branches, so that it is vectorised.
void DrawSpan(float first,
              float step,
              int count,
              std::uint32_t surface,
              float* inverse_depth,
              std::uint32_t* surfaces) {
  for (int i = 0; i < count; ++i) {
    const float candidate = first + step * static_cast<float>(i);
    const bool nearer = candidate > inverse_depth[i];
    inverse_depth[i] = nearer ? candidate : inverse_depth[i];
    surfaces[i] = nearer ? surface : surfaces[i];
  }
}

}  // namespace

bool FaceCamera(const Facet& facet_world,
                const Eigen::Isometry3d& T_camera_world,
                CameraFacet* facet) {
  facet->facet_camera = facet_world;
  std::array<Eigen::Vector3d, 4>& vertices = facet->facet_camera.vertices;
  for (int i = 0; i < facet_world.vertex_count; ++i) {
    Eigen::Vector3d& vertex = vertices[static_cast<std::size_t>(i)];
    vertex = T_camera_world * vertex;
  }
  facet->normal = (vertices[1] - vertices[0]).cross(vertices[2] - vertices[0]).normalized();
  facet->plane_distance_m = facet->normal.dot(vertices[0]);
  if (facet_world.two_sided) return std::abs(facet->plane_distance_m) > kMinPlaneDistanceM;
  return facet->plane_distance_m < -kMinPlaneDistanceM;
}

void DrawFacet(const CameraFacet& facet,
               const PinholeCamera& camera,
               std::uint32_t surface,
               DepthBuffer* buffer) {
  const Edges edges = EdgesOf(facet, camera);
  const PixelPlane inverse_depth = AlongRays(facet.normal / facet.plane_distance_m, camera);
  const Span rows = RowsOf(facet.facet_camera, camera);
  for (int v = rows.begin; v < rows.end; ++v) {
    const Span columns = ColumnsOf(edges, v, camera.width_px);
    if (columns.begin >= columns.end) continue;
    const double first =
        inverse_depth.per_u * columns.begin + inverse_depth.per_v * v + inverse_depth.constant;
    DrawSpan(static_cast<float>(first),
             static_cast<float>(inverse_depth.per_u),
             columns.end - columns.begin,
             surface,
             &buffer->inverse_depth_per_m.At(columns.begin, v),
             &buffer->surface.At(columns.begin, v));
  }
}

}  // namespace steadymap
