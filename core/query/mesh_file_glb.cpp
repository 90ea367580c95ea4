#include "core/query/mesh_file_glb.h"

#include <array>
#include <cassert>
#include <charconv>
#include <cmath>
#include <limits>
#include <memory>
#include <string_view>
#include <utility>

#include <absl/strings/str_cat.h>

#include "core/query/mesh_bytes.h"
#include "core/types/error.h"

namespace steadymap {
namespace {

constexpr std::size_t kRgbaBytes = 4;

// Returns the shortest decimal that parses to the same float, independent of the locale.
std::string Decimal(float value) {
  std::array<char, 32> text{};
  const std::to_chars_result result = std::to_chars(text.data(), text.data() + text.size(), value);
  return {text.data(), result.ptr};
}

std::string DecimalArray(const Eigen::Vector3f& vector) {
  return absl::StrCat(
      "[", Decimal(vector.x()), ",", Decimal(vector.y()), ",", Decimal(vector.z()), "]");
}

// Returns the linear intensity of every sRGB value, both in bytes (IEC 61966-2-1).
std::array<std::uint8_t, 256> MakeLinearOfSrgb() {
  std::array<std::uint8_t, 256> table{};
  for (std::size_t value = 0; value < table.size(); ++value) {
    const double srgb = static_cast<double>(value) / 255.0;
    const double linear = srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
    table[value] = static_cast<std::uint8_t>(std::lround(linear * 255.0));
  }
  return table;
}

// The parts of the JSON chunk that depend on the attributes of the mesh. Each attribute has one
// accessor and one buffer view with the same index.
struct GlbLayout {
  std::string attributes;
  std::string accessors;
  std::string views;
  std::uint64_t bytes = 0;
  int count = 0;

  // `tail` contains the attribute-specific end of the accessor.
  void Add(std::string_view attribute,
           std::uint64_t elements,
           std::uint64_t element_bytes,
           int target,
           std::string_view tail) {
    const std::string_view comma = count == 0 ? "" : ",";
    if (!attribute.empty()) {
      absl::StrAppend(&attributes, std::string(comma), "\"", std::string(attribute), "\":", count);
    }
    absl::StrAppend(&views,
                    std::string(comma),
                    "{\"buffer\":0,\"byteOffset\":",
                    bytes,
                    ",\"byteLength\":",
                    elements * element_bytes,
                    ",\"target\":",
                    target,
                    "}");
    absl::StrAppend(
        &accessors, std::string(comma), "{\"bufferView\":", count, ",", std::string(tail), "}");
    bytes += elements * element_bytes;
    ++count;
  }
};

constexpr int kArrayBuffer = 34962;
constexpr int kElementArrayBuffer = 34963;

GlbLayout LayOut(const Mesh& mesh) {
  Eigen::Vector3f low = mesh.vertices_world.front();
  Eigen::Vector3f high = low;
  for (const Eigen::Vector3f& vertex : mesh.vertices_world) {
    low = low.cwiseMin(vertex);
    high = high.cwiseMax(vertex);
  }
  const std::uint64_t vertices = mesh.vertices_world.size();
  const std::uint64_t indices = 3 * mesh.triangles.size();
  GlbLayout layout;
  layout.Add("POSITION",
             vertices,
             kVectorBytes,
             kArrayBuffer,
             absl::StrCat("\"componentType\":5126,\"type\":\"VEC3\",\"count\":",
                          vertices,
                          ",\"min\":",
                          DecimalArray(low),
                          ",\"max\":",
                          DecimalArray(high)));
  layout.Add("NORMAL",
             vertices,
             kVectorBytes,
             kArrayBuffer,
             absl::StrCat("\"componentType\":5126,\"type\":\"VEC3\",\"count\":", vertices));
  if (!mesh.colors.empty()) {
    layout.Add(
        "COLOR_0",
        vertices,
        kRgbaBytes,
        kArrayBuffer,
        absl::StrCat("\"componentType\":5121,\"normalized\":true,\"type\":\"VEC4\",\"count\":",
                     vertices));
  }
  layout.Add("",
             indices,
             sizeof(std::uint32_t),
             kElementArrayBuffer,
             absl::StrCat("\"componentType\":5125,\"type\":\"SCALAR\",\"count\":", indices));
  return layout;
}

// A rotation by -90 degrees about x maps the world's z axis (up) to glTF's y axis (up).
constexpr char kUprightNode[] =
    "\"rotation\":[-0.70710678118654752,0,0,0.70710678118654752],\"name\":\"map\"";

std::string GlbJson(const Mesh& mesh) {
  const std::string asset = "{\"asset\":{\"version\":\"2.0\",\"generator\":\"steadymap\"}";
  if (mesh.triangles.empty()) {
    return absl::StrCat(
        asset, ",\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{", kUprightNode, "}]}");
  }
  const GlbLayout layout = LayOut(mesh);
  // Vertex colours are multiplied by the base colour of the material, which is therefore white with
  // colours.
  const char* base_color = mesh.colors.empty() ? "[0.6,0.6,0.6,1]" : "[1,1,1,1]";
  return absl::StrCat(
      asset,
      ",\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0,",
      kUprightNode,
      "}],\"meshes\":[{\"primitives\":[{\"attributes\":{",
      layout.attributes,
      "},\"indices\":",
      layout.count - 1,
      ",\"material\":0,\"mode\":4}]}],",
      "\"materials\":[{\"doubleSided\":true,\"pbrMetallicRoughness\":{\"baseColorFactor\":",
      base_color,
      ",\"metallicFactor\":0,\"roughnessFactor\":1}}],\"accessors\":[",
      layout.accessors,
      "],\"bufferViews\":[",
      layout.views,
      "],\"buffers\":[{\"byteLength\":",
      layout.bytes,
      "}]}");
}

void AppendNumber(std::uint64_t value, std::string* file) {
  assert(value <= std::numeric_limits<std::uint32_t>::max());
  const auto narrow = static_cast<std::uint32_t>(value);
  AppendBytes(&narrow, sizeof(narrow), file);
}

/// Returns the sections of the binary chunk. The length of every element is a multiple of four
/// bytes, so no padding is necessary.
std::vector<FileSection> GlbSections(const std::shared_ptr<const Mesh>& mesh) {
  const auto append_vertex = [mesh](std::size_t i, std::string* file) {
    AppendBytes(mesh->vertices_world[i].data(), kVectorBytes, file);
  };
  const auto append_normal = [mesh](std::size_t i, std::string* file) {
    AppendBytes(mesh->normals_world[i].data(), kVectorBytes, file);
  };
  const auto append_color = [mesh, linear_of_srgb = MakeLinearOfSrgb()](std::size_t i,
                                                                        std::string* file) {
    const Rgb& color = mesh->colors[i];
    const std::array<std::uint8_t, kRgbaBytes> rgba = {
        linear_of_srgb[color[0]], linear_of_srgb[color[1]], linear_of_srgb[color[2]], 255};
    AppendBytes(rgba.data(), rgba.size(), file);
  };
  const auto append_triangle = [mesh](std::size_t i, std::string* file) {
    AppendBytes(mesh->triangles[i].data(), kTriangleBytes, file);
  };
  return {{mesh->vertices_world.size(), kVectorBytes, append_vertex},
          {mesh->normals_world.size(), kVectorBytes, append_normal},
          {mesh->colors.size(), kRgbaBytes, append_color},
          {mesh->triangles.size(), kTriangleBytes, append_triangle}};
}

}  // namespace

std::uint64_t GlbBufferBytes(std::uint64_t vertices, std::uint64_t triangles, bool with_colors) {
  return vertices * (2 * kVectorBytes + (with_colors ? kRgbaBytes : 0)) +
         triangles * kTriangleBytes;
}

absl::StatusOr<std::unique_ptr<FileEncoder>> MakeGlbEncoder(Mesh mesh) {
  AssertValid(mesh);
  const std::uint64_t buffer_bytes =
      mesh.triangles.empty()
          ? 0
          : GlbBufferBytes(mesh.vertices_world.size(), mesh.triangles.size(), !mesh.colors.empty());
  std::string json = GlbJson(mesh);
  json.resize((json.size() + 3) / 4 * 4, ' ');
  constexpr std::uint64_t kFileHeaderBytes = 12;
  constexpr std::uint64_t kChunkHeaderBytes = 8;
  const std::uint64_t file_bytes = kFileHeaderBytes + kChunkHeaderBytes + json.size() +
                                   (buffer_bytes == 0 ? 0 : kChunkHeaderBytes + buffer_bytes);
  if (file_bytes > std::numeric_limits<std::uint32_t>::max()) {
    return MakeError(
        absl::StatusCode::kOutOfRange,
        reason::kBadValue,
        absl::StrCat("a GLB file is limited to 4 GiB, the mesh needs ", file_bytes, " bytes"));
  }
  std::string head = "glTF";
  AppendNumber(2, &head);
  AppendNumber(file_bytes, &head);
  AppendNumber(json.size(), &head);
  head += "JSON";
  head += json;
  if (buffer_bytes == 0) return MakeSectionEncoder(std::move(head), {});
  AppendNumber(buffer_bytes, &head);
  head += std::string_view("BIN\0", 4);
  return MakeSectionEncoder(std::move(head),
                            GlbSections(std::make_shared<const Mesh>(std::move(mesh))));
}

absl::StatusOr<std::string> EncodeGlb(Mesh mesh) {
  absl::StatusOr<std::unique_ptr<FileEncoder>> encoder = MakeGlbEncoder(std::move(mesh));
  if (!encoder.ok()) return encoder.status();
  return EncodeWhole(encoder->get());
}

}  // namespace steadymap
