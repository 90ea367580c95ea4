#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "core/frame/frame.h"

namespace steadymap {

/// Colour of vertices without known colour in a mesh with colours: mid-grey.
inline constexpr Rgb kUnknownColor = {128, 128, 128};

/// A triangle mesh in the world frame. Triangles are wound counter-clockwise as seen from the
/// observed side.
struct Mesh {
  std::vector<Eigen::Vector3f> vertices_world;          ///< Metres.
  std::vector<Eigen::Vector3f> normals_world;           ///< Unit length, one per vertex.
  std::vector<Rgb> colors;                              ///< One per vertex. Empty: no colours.
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< Indices into the vertices.
};

}  // namespace steadymap
