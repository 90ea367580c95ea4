#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <variant>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

/// The shapes of simulated scenes, each in the frame of its object.
namespace steadymap {

/// A closed surface of triangles, object frame, metres. Triangles are counter-clockwise as seen
/// from outside; the inside is invisible.
struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices_object;
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< Indices into the vertices.
};

/// A cuboid centred at the object's origin.
struct BoxShape {
  Eigen::Vector3d size_m = Eigen::Vector3d::Ones();  ///< Full side lengths, each > 0.
};

/// A rectangle in the object's xy plane, centred at its origin, visible from both sides.
struct RectangleShape {
  Eigen::Vector2d size_m = Eigen::Vector2d::Ones();  ///< Full side lengths, each > 0.
};

/// A triangle mesh; objects of equal shape share one.
struct MeshShape {
  std::shared_ptr<const TriangleMesh> mesh;
};

/// Returns a shape that owns `mesh`.
MeshShape ShareMesh(TriangleMesh mesh);

using Shape = std::variant<BoxShape, RectangleShape, MeshShape>;

/// A flat convex piece of a surface: a triangle or a quadrilateral.
struct Facet {
  std::array<Eigen::Vector3d, 4> vertices;  ///< Metres; counter-clockwise from outside.
  int vertex_count = 0;                     ///< 3 or 4.
  bool two_sided = false;                   ///< Visible from behind, too.
};

/// Returns the whole surface of `shape`, transformed by `T_destination_object`, without facets of
/// zero area.
std::vector<Facet> FacetsOf(const Shape& shape, const Eigen::Isometry3d& T_destination_object);

/// Returns the radius of a sphere about the object's origin that contains `shape`, metres.
double BoundingRadiusM(const Shape& shape);

/// A profile point of a surface of revolution.
struct ProfilePoint {
  double radius_m = 0.0;  ///< Distance from the z axis; 0 closes the surface.
  double height_m = 0.0;  ///< Along the z axis.
};

/// Rotates `profile`, which runs from bottom to top and starts and ends with radius 0, about the z
/// axis in `segments` (>= 3) steps.
TriangleMesh MakeRevolvedMesh(const std::vector<ProfilePoint>& profile, int segments);

/// Returns a sphere about the origin with all vertices exactly on it; `segments` (>= 3) steps of
/// longitude and half as many of latitude.
TriangleMesh MakeSphereMesh(double radius_m, int segments);

/// Adds a cuboid with side lengths `size_m` centred at `center_object` to `mesh`.
void AppendBox(const Eigen::Vector3d& size_m,
               const Eigen::Vector3d& center_object,
               TriangleMesh* mesh);

}  // namespace steadymap
