#include "client/bench/evaluation/truth/surface_points.h"

#include <algorithm>
#include <cmath>

#include "core/map/placed_volume.h"
#include "core/query/map_mesh.h"

namespace steadymap {
namespace {

// If the sides of a triangle are divided into `n` parts, the centres of the resulting small
// triangles are about two thirds of a part apart.
constexpr float kTriangleSideToSpacing = 1.5F;

int PiecesAlong(float length_m, double spacing_m) {
  return std::max(1, static_cast<int>(std::ceil(length_m / static_cast<float>(spacing_m))));
}

// Adds the centres of the `n` * `n` small triangles.
void SampleTriangle(const std::array<Eigen::Vector3f, 3>& corners,
                    double spacing_m,
                    std::vector<SurfacePoint>* points) {
  const Eigen::Vector3f first = corners[1] - corners[0];
  const Eigen::Vector3f second = corners[2] - corners[0];
  const Eigen::Vector3f across = first.cross(second);
  if (!(across.norm() > 0.0F)) return;
  const Eigen::Vector3f normal = across.normalized();
  const float longest_m = std::max({first.norm(), second.norm(), (second - first).norm()});
  const int n = PiecesAlong(longest_m / kTriangleSideToSpacing, spacing_m);
  const auto add = [&](float i, float j) {
    const auto pieces = static_cast<float>(n);
    points->push_back({corners[0] + first * (i / pieces) + second * (j / pieces), normal});
  };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; i + j < n; ++j) {
      const auto row = static_cast<float>(i);
      const auto column = static_cast<float>(j);
      add(row + 1.0F / 3, column + 1.0F / 3);
      if (i + j + 1 < n) add(row + 2.0F / 3, column + 2.0F / 3);
    }
  }
}

void SampleParallelogram(const Facet& facet, double spacing_m, std::vector<SurfacePoint>* points) {
  const Eigen::Vector3f corner = facet.vertices[0].cast<float>();
  const Eigen::Vector3f first = facet.vertices[1].cast<float>() - corner;
  const Eigen::Vector3f second = facet.vertices[3].cast<float>() - corner;
  const Eigen::Vector3f normal = first.cross(second).normalized();
  const int columns = PiecesAlong(first.norm(), spacing_m);
  const int rows = PiecesAlong(second.norm(), spacing_m);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const float along = (static_cast<float>(column) + 0.5F) / static_cast<float>(columns);
      const float up = (static_cast<float>(row) + 0.5F) / static_cast<float>(rows);
      points->push_back({corner + along * first + up * second, normal});
    }
  }
}

}  // namespace

std::vector<SurfacePoint> SampleMesh(const Mesh& mesh, double spacing_m) {
  std::vector<SurfacePoint> points;
  for (const std::array<std::uint32_t, 3>& triangle : mesh.triangles) {
    SampleTriangle({mesh.vertices_world[triangle[0]],
                    mesh.vertices_world[triangle[1]],
                    mesh.vertices_world[triangle[2]]},
                   spacing_m,
                   &points);
  }
  return points;
}

std::vector<SurfacePoint> SampleFacets(const std::vector<Facet>& facets_world, double spacing_m) {
  std::vector<SurfacePoint> points;
  for (const Facet& facet : facets_world) {
    if (facet.vertex_count == 4) {
      SampleParallelogram(facet, spacing_m, &points);
    } else {
      SampleTriangle({facet.vertices[0].cast<float>(),
                      facet.vertices[1].cast<float>(),
                      facet.vertices[2].cast<float>()},
                     spacing_m,
                     &points);
    }
  }
  return points;
}

std::vector<SurfacePoint> SampleObject(const MapObject& object,
                                       const VoxelScale& scale,
                                       double spacing_m) {
  const PlacedVolume volume = VolumeOf(object);
  return SampleMesh(ExtractMapMesh({&volume, 1}, scale, nullptr), spacing_m);
}

std::vector<SurfacePoint> SampleMap(const MapSnapshot& snapshot, double spacing_m) {
  return SampleMesh(ExtractMapMesh(ShownVolumes(snapshot), snapshot.scale, nullptr), spacing_m);
}

}  // namespace steadymap
