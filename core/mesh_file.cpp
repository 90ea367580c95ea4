#include "core/mesh_file.h"

#include <algorithm>
#include <cassert>

#include <absl/strings/str_cat.h>

#include "core/mesh_bytes.h"

namespace steadymap {
namespace {

std::string PlyHeader(const Mesh& mesh) {
  std::string header = absl::StrCat(
      "ply\nformat binary_little_endian 1.0\ncomment steadymap: metres, world frame, z up\n",
      "element vertex ",
      mesh.vertices_world.size(),
      "\nproperty float x\nproperty float y\nproperty float z\n",
      "property float nx\nproperty float ny\nproperty float nz\n");
  if (!mesh.colors.empty()) {
    header += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  }
  return absl::StrCat(header,
                      "element face ",
                      mesh.triangles.size(),
                      "\nproperty list uchar int vertex_indices\nend_header\n");
}

}  // namespace

void AssertWhole([[maybe_unused]] const Mesh& mesh) {
  assert(mesh.normals_world.size() == mesh.vertices_world.size());
  assert(mesh.colors.empty() || mesh.colors.size() == mesh.vertices_world.size());
  assert(std::all_of(mesh.triangles.begin(), mesh.triangles.end(), [&mesh](const auto& triangle) {
    return *std::max_element(triangle.begin(), triangle.end()) < mesh.vertices_world.size();
  }));
}

void AppendBytes(const void* bytes, std::size_t count, std::string* file) {
  file->append(static_cast<const char*>(bytes), count);
}

std::string EncodePly(const Mesh& mesh) {
  AssertWhole(mesh);
  std::string file = PlyHeader(mesh);
  const std::size_t vertex_bytes = 2 * kVectorBytes + (mesh.colors.empty() ? 0 : sizeof(Rgb));
  file.reserve(file.size() + mesh.vertices_world.size() * vertex_bytes +
               mesh.triangles.size() * (1 + kTriangleBytes));
  for (std::size_t i = 0; i < mesh.vertices_world.size(); ++i) {
    AppendBytes(mesh.vertices_world[i].data(), kVectorBytes, &file);
    AppendBytes(mesh.normals_world[i].data(), kVectorBytes, &file);
    if (!mesh.colors.empty()) AppendBytes(mesh.colors[i].data(), sizeof(Rgb), &file);
  }
  for (const std::array<std::uint32_t, 3>& triangle : mesh.triangles) {
    file += '\x03';
    AppendBytes(triangle.data(), kTriangleBytes, &file);
  }
  return file;
}

}  // namespace steadymap
