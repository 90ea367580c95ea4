#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <variant>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

/// The solids that simulated scenes are made of, each in the frame of its object.
namespace steadymap {

/// A closed surface of triangles, object frame, metres. Triangles wind counter-clockwise seen from
/// outside; the inside is never seen.
struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices_object;
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< Indices into the vertices.
};

/// A cuboid centred on the object's origin.
struct BoxShape {
  Eigen::Vector3d size_m = Eigen::Vector3d::Ones();  ///< Full side lengths, each > 0.
};

/// A rectangle in the object's xy plane, centred on its origin, seen from both sides.
struct RectangleShape {
  Eigen::Vector2d size_m = Eigen::Vector2d::Ones();  ///< Full side lengths, each > 0.
};

/// A triangle mesh; objects of the same form share one.
struct MeshShape {
  std::shared_ptr<const TriangleMesh> mesh;
};

/// A shape of which `mesh` is the only user so far.
MeshShape ShareMesh(TriangleMesh mesh);

using Shape = std::variant<BoxShape, RectangleShape, MeshShape>;

/// A flat convex piece of a surface: a triangle or a quadrilateral.
struct Facet {
  std::array<Eigen::Vector3d, 4> vertices;  ///< Metres; counter-clockwise seen from outside.
  int vertex_count = 0;                     ///< 3 or 4.
  bool two_sided = false;                   ///< Whether it is seen from behind, too.
};

/// The whole surface of `shape`, moved by `T_destination_object`. Facets without area are left out.
std::vector<Facet> FacetsOf(const Shape& shape, const Eigen::Isometry3d& T_destination_object);

/// Radius of a sphere about the object's origin that holds all of `shape`, metres.
double BoundingRadiusM(const Shape& shape);

/// A point of a profile that a surface of revolution is turned from.
struct ProfilePoint {
  double radius_m = 0.0;  ///< Distance from the z axis; 0 closes the surface.
  double height_m = 0.0;  ///< Along the z axis.
};

/// Turns `profile`, which runs from the bottom to the top and starts and ends with radius 0, about
/// the z axis in `segments` (>= 3) steps.
TriangleMesh MakeRevolvedMesh(const std::vector<ProfilePoint>& profile, int segments);

/// A sphere about the origin whose vertices lie on it exactly; `segments` (>= 3) steps of longitude
/// and half as many of latitude.
TriangleMesh MakeSphereMesh(double radius_m, int segments);

/// Adds a cuboid with side lengths `size_m` centred at `center_object` to `mesh`.
void AppendBox(const Eigen::Vector3d& size_m,
               const Eigen::Vector3d& center_object,
               TriangleMesh* mesh);

}  // namespace steadymap
