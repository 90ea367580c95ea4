#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "core/frame/frame.h"

namespace steadymap {

/// Where some of a mesh's colours are known, the others are mid-grey.
inline constexpr Rgb kUnknownColor = {128, 128, 128};

/// A triangle surface in the world frame. Triangles wind counter-clockwise seen from the side that
/// was observed.
struct Mesh {
  std::vector<Eigen::Vector3f> vertices_world;          ///< Metres.
  std::vector<Eigen::Vector3f> normals_world;           ///< Unit, one a vertex.
  std::vector<Rgb> colors;                              ///< One a vertex; empty: none is known.
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< Indices into the vertices.
};

}  // namespace steadymap
