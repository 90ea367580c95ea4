#include "core/query/mesh_file.h"

#include <array>
#include <cstring>
#include <numeric>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include "core/query/mesh_file_glb.h"

namespace steadymap {
namespace {

// Returns three triangles of a corner. Some coordinates need more than six significant digits.
Mesh CornerMesh(bool with_colors) {
  Mesh mesh;
  mesh.vertices_world = {
      {0.1F, 0.2F, 0.3F}, {1.0000001F, 0.F, 0.F}, {0.F, 1.F, -2.5F}, {7.F, -3.F, 1e-7F}};
  mesh.normals_world = {{0, 0, 1}, {0, 1, 0}, {1, 0, 0}, {0, 0, -1}};
  if (with_colors) mesh.colors = {{0, 128, 255}, {255, 0, 10}, {1, 2, 3}, {188, 64, 200}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}};
  return mesh;
}

// Returns a mesh large enough that each of its files has several pieces.
Mesh LargeMesh() {
  constexpr std::uint32_t kVertices = 100'000;
  Mesh mesh;
  for (std::uint32_t i = 0; i < kVertices; ++i) {
    const auto value = static_cast<float>(i);
    mesh.vertices_world.emplace_back(value, -value, 0.1F * value);
    mesh.normals_world.emplace_back(0.0F, 1.0F, value);
    mesh.colors.push_back({static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i >> 8), 7});
    mesh.triangles.push_back({i, (i + 1) % kVertices, (i + 2) % kVertices});
  }
  return mesh;
}

std::vector<Mesh> SmallAndLargeMeshes() {
  return {CornerMesh(false), CornerMesh(true), LargeMesh()};
}

// Returns the pieces of a file. Fails the test if a piece is empty or too long.
std::vector<std::string> PiecesOf(FileEncoder* encoder) {
  std::vector<std::string> pieces;
  for (std::string piece; *encoder->Next(&piece);) {
    EXPECT_FALSE(piece.empty());
    EXPECT_LE(piece.size(), kFilePieceBytes);
    pieces.push_back(piece);
  }
  std::string piece = "old";
  EXPECT_FALSE(*encoder->Next(&piece)) << "the end stays the end";
  EXPECT_EQ(piece, "");
  return pieces;
}

// Returns the number of pieces of a file of `bytes`. Each piece has the maximum size, less at most
// one element.
std::size_t PiecesNeeded(std::size_t bytes) { return bytes / kFilePieceBytes + 1; }

std::string Joined(const std::vector<std::string>& pieces) {
  return std::accumulate(pieces.begin(), pieces.end(), std::string());
}

template <typename Number>
Number Take(std::string_view* bytes) {
  Number value{};
  EXPECT_GE(bytes->size(), sizeof(value));
  if (bytes->size() < sizeof(value)) return value;
  std::memcpy(&value, bytes->data(), sizeof(value));
  bytes->remove_prefix(sizeof(value));
  return value;
}

Eigen::Vector3f TakeVector(std::string_view* bytes) {
  const auto x = Take<float>(bytes);
  const auto y = Take<float>(bytes);
  return {x, y, Take<float>(bytes)};
}

// Returns the lines of the header of a PLY file, and the rest of the file in `body`.
std::vector<std::string> PlyHeaderLines(const std::string& file, std::string_view* body) {
  const std::string end = "end_header\n";
  const std::size_t position = file.find(end);
  EXPECT_NE(position, std::string::npos);
  *body = std::string_view(file).substr(position + end.size());
  std::vector<std::string> lines;
  std::istringstream header(file.substr(0, position));
  for (std::string line; std::getline(header, line);) {
    if (line.rfind("comment", 0) != 0) lines.push_back(line);
  }
  return lines;
}

TEST(EncodePly, ReadsBackByteForByte) {
  for (const Mesh& mesh : SmallAndLargeMeshes()) {
    const bool with_colors = !mesh.colors.empty();
    const std::string file = EncodePly(mesh);
    std::string_view body;
    std::vector<std::string> expected = {
        "ply",
        "format binary_little_endian 1.0",
        "element vertex " + std::to_string(mesh.vertices_world.size()),
        "property float x",
        "property float y",
        "property float z",
        "property float nx",
        "property float ny",
        "property float nz"};
    if (with_colors) {
      expected.insert(expected.end(),
                      {"property uchar red", "property uchar green", "property uchar blue"});
    }
    expected.insert(expected.end(),
                    {"element face " + std::to_string(mesh.triangles.size()),
                     "property list uchar int vertex_indices"});
    EXPECT_EQ(PlyHeaderLines(file, &body), expected);
    for (std::size_t i = 0; i < mesh.vertices_world.size(); ++i) {
      ASSERT_EQ(TakeVector(&body), mesh.vertices_world[i]);
      EXPECT_EQ(TakeVector(&body), mesh.normals_world[i]);
      if (with_colors) {
        EXPECT_EQ(Take<Rgb>(&body), mesh.colors[i]);
      }
    }
    for (const std::array<std::uint32_t, 3>& triangle : mesh.triangles) {
      EXPECT_EQ(Take<std::uint8_t>(&body), 3);
      for (const std::uint32_t index : triangle) EXPECT_EQ(Take<std::uint32_t>(&body), index);
    }
    EXPECT_TRUE(body.empty());
  }
}

TEST(MeshEncoders, MakePiecesOfBoundedLengthThatAddUpToTheFile) {
  const Mesh mesh = LargeMesh();
  const std::vector<std::string> ply = PiecesOf(MakePlyEncoder(mesh).get());
  EXPECT_EQ(ply.size(), PiecesNeeded(std::size_t{100'000} * (27 + 13)));
  EXPECT_TRUE(Joined(ply) == EncodePly(mesh));
  const std::vector<std::string> glb = PiecesOf(MakeGlbEncoder(mesh)->get());
  EXPECT_EQ(glb.size(), PiecesNeeded(std::size_t{100'000} * (28 + 12)));
  EXPECT_TRUE(Joined(glb) == *EncodeGlb(mesh));
}

TEST(EncodePly, WritesAnEmptyMeshWithoutElements) {
  const std::string file = EncodePly({});
  std::string_view body;
  const std::vector<std::string> lines = PlyHeaderLines(file, &body);
  EXPECT_EQ(lines[2], "element vertex 0");
  EXPECT_EQ(lines[9], "element face 0");
  EXPECT_TRUE(body.empty());
}

// A parsed GLB file. The parser checks the rules of the container format.
struct Glb {
  google::protobuf::Struct json;
  std::string_view buffer;

  const google::protobuf::Struct& At(const std::string& list, int i) const {
    return json.fields().at(list).list_value().values(i).struct_value();
  }

  double Number(const std::string& list, int i, const std::string& field) const {
    return At(list, i).fields().at(field).number_value();
  }

  // Returns the bytes of the buffer view of an accessor.
  std::string_view Bytes(int accessor) const {
    const int view = static_cast<int>(Number("accessors", accessor, "bufferView"));
    return buffer.substr(static_cast<std::size_t>(Number("bufferViews", view, "byteOffset")),
                         static_cast<std::size_t>(Number("bufferViews", view, "byteLength")));
  }
};

Glb Parse(std::string_view file) {
  Glb glb;
  const std::size_t total = file.size();
  EXPECT_EQ(total % 4, 0U);
  EXPECT_EQ(Take<std::uint32_t>(&file), 0x46546C67U);
  EXPECT_EQ(Take<std::uint32_t>(&file), 2U);
  EXPECT_EQ(Take<std::uint32_t>(&file), total);
  const auto json_bytes = Take<std::uint32_t>(&file);
  EXPECT_EQ(json_bytes % 4, 0U);
  EXPECT_EQ(Take<std::uint32_t>(&file), 0x4E4F534AU);
  const auto status = google::protobuf::util::JsonStringToMessage(
      std::string(file.substr(0, json_bytes)), &glb.json);
  EXPECT_TRUE(status.ok()) << status.ToString();
  file.remove_prefix(json_bytes);
  if (file.empty()) return glb;
  const auto buffer_bytes = Take<std::uint32_t>(&file);
  EXPECT_EQ(Take<std::uint32_t>(&file), 0x004E4942U);
  EXPECT_EQ(file.size(), buffer_bytes);
  glb.buffer = file;
  EXPECT_EQ(glb.Number("buffers", 0, "byteLength"), static_cast<double>(file.size()));
  return glb;
}

TEST(EncodeGlb, ReadsBackPositionsNormalsAndIndices) {
  for (const Mesh& mesh : SmallAndLargeMeshes()) {
    const bool with_colors = !mesh.colors.empty();
    const std::size_t vertices = mesh.vertices_world.size();
    const absl::StatusOr<std::string> file = EncodeGlb(mesh);
    ASSERT_TRUE(file.ok()) << file.status();
    const Glb glb = Parse(*file);
    EXPECT_EQ(glb.buffer.size(), GlbBufferBytes(vertices, mesh.triangles.size(), with_colors));
    const auto& primitive = glb.At("meshes", 0)
                                .fields()
                                .at("primitives")
                                .list_value()
                                .values(0)
                                .struct_value()
                                .fields();
    const auto& attributes = primitive.at("attributes").struct_value().fields();
    EXPECT_EQ(attributes.contains("COLOR_0"), with_colors);
    std::string_view positions =
        glb.Bytes(static_cast<int>(attributes.at("POSITION").number_value()));
    std::string_view normals = glb.Bytes(static_cast<int>(attributes.at("NORMAL").number_value()));
    std::string_view indices = glb.Bytes(static_cast<int>(primitive.at("indices").number_value()));
    ASSERT_EQ(positions.size(), vertices * 12);
    ASSERT_EQ(normals.size(), vertices * 12);
    ASSERT_EQ(indices.size(), mesh.triangles.size() * 12);
    for (std::size_t i = 0; i < vertices; ++i) {
      ASSERT_EQ(TakeVector(&positions), mesh.vertices_world[i]);
      EXPECT_EQ(TakeVector(&normals), mesh.normals_world[i]);
    }
    for (const std::array<std::uint32_t, 3>& triangle : mesh.triangles) {
      for (const std::uint32_t index : triangle) EXPECT_EQ(Take<std::uint32_t>(&indices), index);
    }
  }
}

TEST(EncodeGlb, DeclaresTheExactExtentOfThePositions) {
  const std::string file = *EncodeGlb(CornerMesh(false));
  const Glb glb = Parse(file);
  const Eigen::Vector3f low(0.F, -3.F, -2.5F);
  const Eigen::Vector3f high(7.F, 1.F, 0.3F);
  const auto& fields = glb.At("accessors", 0).fields();
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(static_cast<float>(fields.at("min").list_value().values(axis).number_value()),
              low[axis]);
    EXPECT_EQ(static_cast<float>(fields.at("max").list_value().values(axis).number_value()),
              high[axis]);
  }
}

TEST(EncodeGlb, TurnsTheWorldUpright) {
  const std::string file = *EncodeGlb(CornerMesh(false));
  const Glb glb = Parse(file);
  const auto& rotation = glb.At("nodes", 0).fields().at("rotation").list_value();
  const Eigen::Quaterniond R_gltf_world(rotation.values(3).number_value(),
                                        rotation.values(0).number_value(),
                                        rotation.values(1).number_value(),
                                        rotation.values(2).number_value());
  EXPECT_NEAR((R_gltf_world * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitY()).norm(), 0, 1e-9);
  EXPECT_NEAR((R_gltf_world * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitX()).norm(), 0, 1e-9);
}

TEST(EncodeGlb, WritesColoursAsOpaqueNormalizedLinearBytes) {
  const std::string file = *EncodeGlb(CornerMesh(true));
  const Glb glb = Parse(file);
  EXPECT_EQ(glb.Number("accessors", 2, "componentType"), 5121);
  EXPECT_TRUE(glb.At("accessors", 2).fields().at("normalized").bool_value());
  std::string_view colors = glb.Bytes(2);
  // sRGB 128 is 21.6 % of the linear intensity of 255, and 188 is 50.3 %.
  EXPECT_EQ((Take<std::array<std::uint8_t, 4>>(&colors)),
            (std::array<std::uint8_t, 4>{0, 55, 255, 255}));
  Take<std::uint64_t>(&colors);
  EXPECT_EQ((Take<std::array<std::uint8_t, 4>>(&colors)),
            (std::array<std::uint8_t, 4>{128, 13, 147, 255}));
  EXPECT_TRUE(glb.At("materials", 0).fields().at("doubleSided").bool_value());
}

TEST(EncodeGlb, WritesAnEmptyMeshAsAnEmptyScene) {
  const std::string file = *EncodeGlb({});
  const Glb glb = Parse(file);
  EXPECT_TRUE(glb.buffer.empty());
  EXPECT_FALSE(glb.json.fields().contains("meshes"));
  EXPECT_FALSE(glb.json.fields().contains("buffers"));
}

TEST(GlbBufferBytes, DoesNotWrapBeyondFourGibibytes) {
  EXPECT_EQ(GlbBufferBytes(std::uint64_t{1} << 32, 0, true), (std::uint64_t{1} << 32) * 28);
}

}  // namespace
}  // namespace steadymap
