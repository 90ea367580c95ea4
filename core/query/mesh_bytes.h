#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/query/file_encoder.h"
#include "core/volume/mesh.h"

/// Private to the mesh files: parts common to all formats.
namespace steadymap {

/// Asserts that a mesh has one normal per vertex, one colour per vertex or none, and valid indices.
void AssertValid(const Mesh& mesh);

/// Appends `count` bytes in memory order.
void AppendBytes(const void* bytes, std::size_t count, std::string* file);

/// A section of a file: elements of equal length. `append` appends the element with a given index.
struct FileSection {
  std::size_t elements = 0;
  std::size_t element_bytes = 0;
  std::function<void(std::size_t element, std::string* file)> append;
};

/// Returns the encoder of a file that consists of a head, at most `kFilePieceBytes` long, and
/// sections.
std::unique_ptr<FileEncoder> MakeSectionEncoder(std::string head,
                                                std::vector<FileSection> sections);

/// Bytes of three floats, and of the three indices of a triangle.
inline constexpr std::size_t kVectorBytes = 3 * sizeof(float);
inline constexpr std::size_t kTriangleBytes = 3 * sizeof(std::uint32_t);

static_assert(sizeof(Eigen::Vector3f) == kVectorBytes, "vectors are copied whole");
static_assert(std::endian::native == std::endian::little, "numbers are copied in memory order");

}  // namespace steadymap
