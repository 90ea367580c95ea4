#include "core/query/mesh_file.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include <absl/strings/str_cat.h>

#include "core/query/mesh_bytes.h"

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

/// See `MakeSectionEncoder`.
class SectionEncoder final : public FileEncoder {
 public:
  SectionEncoder(std::string head, std::vector<FileSection> sections)
      : head_(std::move(head)), sections_(std::move(sections)) {
    assert(head_.size() <= kFilePieceBytes);
  }

  absl::StatusOr<bool> Next(std::string* piece) override {
    *piece = std::exchange(head_, {});
    piece->reserve(kFilePieceBytes);
    while (section_ < sections_.size()) {
      const FileSection& section = sections_[section_];
      const std::size_t room = (kFilePieceBytes - piece->size()) / section.element_bytes;
      const std::size_t end = std::min(section.elements, next_element_ + room);
      for (; next_element_ < end; ++next_element_) section.append(next_element_, piece);
      if (next_element_ < section.elements) break;
      ++section_;
      next_element_ = 0;
    }
    return !piece->empty();
  }

 private:
  std::string head_;  ///< Empty after it is written.
  const std::vector<FileSection> sections_;
  std::size_t section_ = 0;
  std::size_t next_element_ = 0;  ///< In the current section.
};

}  // namespace

void AssertValid([[maybe_unused]] const Mesh& mesh) {
  assert(mesh.normals_world.size() == mesh.vertices_world.size());
  assert(mesh.colors.empty() || mesh.colors.size() == mesh.vertices_world.size());
  assert(std::all_of(mesh.triangles.begin(), mesh.triangles.end(), [&mesh](const auto& triangle) {
    return *std::max_element(triangle.begin(), triangle.end()) < mesh.vertices_world.size();
  }));
}

void AppendBytes(const void* bytes, std::size_t count, std::string* file) {
  file->append(static_cast<const char*>(bytes), count);
}

std::unique_ptr<FileEncoder> MakeSectionEncoder(std::string head,
                                                std::vector<FileSection> sections) {
  return std::make_unique<SectionEncoder>(std::move(head), std::move(sections));
}

std::unique_ptr<FileEncoder> MakePlyEncoder(Mesh mesh) {
  AssertValid(mesh);
  const auto shared = std::make_shared<const Mesh>(std::move(mesh));
  const bool has_colors = !shared->colors.empty();
  const auto append_vertex = [shared, has_colors](std::size_t i, std::string* file) {
    AppendBytes(shared->vertices_world[i].data(), kVectorBytes, file);
    AppendBytes(shared->normals_world[i].data(), kVectorBytes, file);
    if (has_colors) AppendBytes(shared->colors[i].data(), sizeof(Rgb), file);
  };
  const auto append_triangle = [shared](std::size_t i, std::string* file) {
    *file += '\x03';
    AppendBytes(shared->triangles[i].data(), kTriangleBytes, file);
  };
  return MakeSectionEncoder(PlyHeader(*shared),
                            {{shared->vertices_world.size(),
                              2 * kVectorBytes + (has_colors ? sizeof(Rgb) : 0),
                              append_vertex},
                             {shared->triangles.size(), 1 + kTriangleBytes, append_triangle}});
}

std::string EncodePly(Mesh mesh) { return *EncodeWhole(MakePlyEncoder(std::move(mesh)).get()); }

}  // namespace steadymap
