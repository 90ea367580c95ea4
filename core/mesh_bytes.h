#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>

#include "core/mesh.h"

/// Private to the mesh files: what the formats share.
namespace steadymap {

/// Asserts that a mesh has one normal a vertex, one colour a vertex or none, and valid indices.
void AssertWhole(const Mesh& mesh);

/// Appends `count` bytes as they lie in memory.
void AppendBytes(const void* bytes, std::size_t count, std::string* file);

/// Bytes of three floats, and of a triangle's three indices.
inline constexpr std::size_t kVectorBytes = 3 * sizeof(float);
inline constexpr std::size_t kTriangleBytes = 3 * sizeof(std::uint32_t);

static_assert(sizeof(Eigen::Vector3f) == kVectorBytes, "vectors are copied whole");
static_assert(std::endian::native == std::endian::little, "numbers are copied as they lie");

}  // namespace steadymap
