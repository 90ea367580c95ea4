#include "client/bench/simulator/scene/shape.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <utility>

namespace steadymap {
namespace {

// Smaller facets are invisible, and their planes are undefined.
constexpr double kMinDoubleAreaM2 = 1e-12;

// Corner i of a box is on the upper side along x, y, z if bit 0, 1, 2 of i is set.
using BoxCorners = std::array<Eigen::Vector3d, 8>;
constexpr std::array<std::array<std::uint32_t, 4>, 6> kBoxFaces = {
    {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};

BoxCorners CornersOf(const Eigen::Vector3d& size_m, const Eigen::Vector3d& center) {
  BoxCorners corners;
  for (unsigned i = 0; i < 8; ++i) {
    const Eigen::Vector3d sign(
        (i & 1) != 0 ? 0.5 : -0.5, (i & 2) != 0 ? 0.5 : -0.5, (i & 4) != 0 ? 0.5 : -0.5);
    corners[i] = center + sign.cwiseProduct(size_m);
  }
  return corners;
}

bool HasArea(const Facet& facet) {
  const Eigen::Vector3d first = facet.vertices[1] - facet.vertices[0];
  const Eigen::Vector3d second = facet.vertices[2] - facet.vertices[0];
  return first.cross(second).norm() > kMinDoubleAreaM2;
}

std::vector<Facet> FacetsOfBox(const BoxShape& box, const Eigen::Isometry3d& T_destination_object) {
  BoxCorners corners = CornersOf(box.size_m, Eigen::Vector3d::Zero());
  for (Eigen::Vector3d& corner : corners) corner = T_destination_object * corner;
  std::vector<Facet> facets;
  facets.reserve(kBoxFaces.size());
  for (const auto& [a, b, c, d] : kBoxFaces) {
    facets.push_back({{corners[a], corners[b], corners[c], corners[d]}, 4, false});
  }
  return facets;
}

std::vector<Facet> FacetsOfRectangle(const RectangleShape& rectangle,
                                     const Eigen::Isometry3d& T_destination_object) {
  const double x = rectangle.size_m.x() / 2;
  const double y = rectangle.size_m.y() / 2;
  return {{{T_destination_object * Eigen::Vector3d(-x, -y, 0),
            T_destination_object * Eigen::Vector3d(x, -y, 0),
            T_destination_object * Eigen::Vector3d(x, y, 0),
            T_destination_object * Eigen::Vector3d(-x, y, 0)},
           4,
           true}};
}

std::vector<Facet> FacetsOfMesh(const TriangleMesh& mesh,
                                const Eigen::Isometry3d& T_destination_object) {
  std::vector<Eigen::Vector3d> vertices;
  vertices.reserve(mesh.vertices_object.size());
  for (const Eigen::Vector3d& vertex : mesh.vertices_object)
    vertices.emplace_back(T_destination_object * vertex);
  std::vector<Facet> facets;
  facets.reserve(mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    facets.push_back({{vertices[a], vertices[b], vertices[c], vertices[c]}, 3, false});
  }
  return facets;
}

}  // namespace

MeshShape ShareMesh(TriangleMesh mesh) {
  return {std::make_shared<const TriangleMesh>(std::move(mesh))};
}

std::vector<Facet> FacetsOf(const Shape& shape, const Eigen::Isometry3d& T_destination_object) {
  std::vector<Facet> facets;
  if (const auto* box = std::get_if<BoxShape>(&shape)) {
    facets = FacetsOfBox(*box, T_destination_object);
  } else if (const auto* rectangle = std::get_if<RectangleShape>(&shape)) {
    facets = FacetsOfRectangle(*rectangle, T_destination_object);
  } else {
    facets = FacetsOfMesh(*std::get<MeshShape>(shape).mesh, T_destination_object);
  }
  std::erase_if(facets, [](const Facet& facet) { return !HasArea(facet); });
  return facets;
}

double BoundingRadiusM(const Shape& shape) {
  if (const auto* box = std::get_if<BoxShape>(&shape)) return box->size_m.norm() / 2;
  if (const auto* rectangle = std::get_if<RectangleShape>(&shape)) {
    return rectangle->size_m.norm() / 2;
  }
  double radius_m = 0.0;
  for (const Eigen::Vector3d& vertex : std::get<MeshShape>(shape).mesh->vertices_object) {
    radius_m = std::max(radius_m, vertex.norm());
  }
  return radius_m;
}

TriangleMesh MakeRevolvedMesh(const std::vector<ProfilePoint>& profile, int segments) {
  assert(segments >= 3 && profile.size() >= 3);
  TriangleMesh mesh;
  const auto count = static_cast<std::uint32_t>(segments);
  for (const ProfilePoint& point : profile) {
    for (int i = 0; i < segments; ++i) {
      const double angle_rad = 2 * M_PI * i / segments;
      mesh.vertices_object.emplace_back(point.radius_m * std::cos(angle_rad),
                                        point.radius_m * std::sin(angle_rad),
                                        point.height_m);
    }
  }
  for (std::uint32_t ring = 0; ring + 1 < profile.size(); ++ring) {
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::uint32_t next = (i + 1) % count;
      const std::uint32_t lower = ring * count;
      const std::uint32_t upper = lower + count;
      // At the poles one of the two triangles has no area.
      if (profile[ring].radius_m > 0) {
        mesh.triangles.push_back({lower + i, lower + next, upper + next});
      }
      if (profile[ring + 1].radius_m > 0) {
        mesh.triangles.push_back({lower + i, upper + next, upper + i});
      }
    }
  }
  return mesh;
}

TriangleMesh MakeSphereMesh(double radius_m, int segments) {
  const int rings = std::max(2, segments / 2);
  std::vector<ProfilePoint> profile = {{0.0, -radius_m}};
  for (int i = 1; i < rings; ++i) {
    const double angle_rad = M_PI * i / rings - M_PI / 2;
    profile.push_back({radius_m * std::cos(angle_rad), radius_m * std::sin(angle_rad)});
  }
  profile.push_back({0.0, radius_m});
  return MakeRevolvedMesh(profile, segments);
}

void AppendBox(const Eigen::Vector3d& size_m,
               const Eigen::Vector3d& center_object,
               TriangleMesh* mesh) {
  const auto base = static_cast<std::uint32_t>(mesh->vertices_object.size());
  for (const Eigen::Vector3d& corner : CornersOf(size_m, center_object)) {
    mesh->vertices_object.push_back(corner);
  }
  for (const auto& [a, b, c, d] : kBoxFaces) {
    mesh->triangles.push_back({base + a, base + b, base + c});
    mesh->triangles.push_back({base + a, base + c, base + d});
  }
}

}  // namespace steadymap
