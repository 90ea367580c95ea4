#include "core/volume/tsdf_mesh.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/types/parallel.h"
#include "core/volume/tsdf_sample.h"

namespace steadymap {
namespace {

// The cells of a leaf extend by one voxel into the leaves above, its quads by one cell below.
constexpr int kPatchSide = kLeafSide + 1;

/// Calls `visit(x, y, z)` for each voxel of a box at the origin, z fastest.
template <typename Visitor>
void ForEachVoxel(int end_x, int end_y, int end_z, const Visitor& visit) {
  for (int x = 0; x < end_x; ++x) {
    for (int y = 0; y < end_y; ++y) {
      for (int z = 0; z < end_z; ++z) visit(x, y, z);
    }
  }
}

template <typename Visitor>
void ForEachVoxelOfLeaf(const Visitor& visit) {
  ForEachVoxel(kLeafSide, kLeafSide, kLeafSide, visit);
}

/// The voxels of a leaf and of the first layer of the next leaves along each axis.
class VoxelPatch {
 public:
  void Load(const VoxelReader& reader, float distance_step_m, LeafOrigin origin);

  bool known(int x, int y, int z) const { return known_[At(x, y, z)]; }

  float distance_m(int x, int y, int z) const { return distance_m_[At(x, y, z)]; }

  std::uint32_t color(int x, int y, int z) const { return color_[At(x, y, z)]; }

  bool has_color() const { return has_color_; }

 private:
  static constexpr std::size_t kSide = kPatchSide;
  static constexpr std::size_t kVoxels = kSide * kSide * kSide;

  static std::size_t At(int x, int y, int z) {
    const std::size_t row = static_cast<std::size_t>(x) * kSide + static_cast<std::size_t>(y);
    return row * kSide + static_cast<std::size_t>(z);
  }

  std::array<bool, kVoxels> known_;
  std::array<float, kVoxels> distance_m_;
  std::array<std::uint32_t, kVoxels> color_;
  bool has_color_ = false;
};

void VoxelPatch::Load(const VoxelReader& reader, float distance_step_m, LeafOrigin origin) {
  known_.fill(false);
  has_color_ = false;
  for (int part = 0; part < 8; ++part) {
    const int above_x = (part >> 2) & 1;
    const int above_y = (part >> 1) & 1;
    const int above_z = part & 1;
    const LeafView leaf = reader.FindLeaf({origin.x + above_x * kLeafSide,
                                           origin.y + above_y * kLeafSide,
                                           origin.z + above_z * kLeafSide});
    if (!leaf) continue;
    has_color_ = has_color_ || leaf.color != nullptr;
    const auto end = [](int above) { return above == 1 ? 1 : kLeafSide; };
    ForEachVoxel(end(above_x), end(above_y), end(above_z), [&](int x, int y, int z) {
      const std::size_t offset = OffsetInLeaf(x, y, z);
      const Voxel voxel = leaf.voxels[offset];
      const std::size_t at =
          At(x + above_x * kLeafSide, y + above_y * kLeafSide, z + above_z * kLeafSide);
      known_[at] =
          IsSet(leaf.observed, offset) && (voxel.weight_units() > 1 || voxel.distance_steps() > 0);
      distance_m_[at] = voxel.distance_m(distance_step_m);
      color_[at] = leaf.color == nullptr ? 0 : leaf.color[offset];
    });
  }
}

/// Computes a weighted mean of colours. Ignores voxels without a colour.
class ColorMean {
 public:
  void Add(std::uint32_t color, float weight) {
    if ((color >> 24) == 0) return;
    for (std::size_t channel = 0; channel < 3; ++channel) {
      sums_[channel] += weight * static_cast<float>((color >> (8 * channel)) & 0xFFU);
    }
    weight_ += weight;
  }

  Rgb mean() const {
    if (weight_ <= 0.0F) return kUnknownColor;
    Rgb rgb;
    for (std::size_t channel = 0; channel < 3; ++channel) {
      rgb[channel] = static_cast<std::uint8_t>(std::lround(sums_[channel] / weight_));
    }
    return rgb;
  }

 private:
  std::array<float, 3> sums_{};
  float weight_ = 0.0F;
};

/// The vertex of a cell: position within the cell in voxels, normal, and colour.
struct CellVertex {
  Eigen::Vector3f place;
  Eigen::Vector3f normal;
  Rgb color;
};

/// True if the surface intersects the edge between two adjacent voxels with these distances.
bool IsCrossing(float a_m, float b_m, float max_jump_m) {
  return (a_m <= 0.0F) != (b_m <= 0.0F) && std::abs(a_m - b_m) <= max_jump_m;
}

/// The twelve edges of a cell as pairs of corners; corner `x * 4 + y * 2 + z`.
constexpr std::array<std::array<int, 2>, 12> kCellEdges = {{{0, 4},
                                                            {1, 5},
                                                            {2, 6},
                                                            {3, 7},
                                                            {0, 2},
                                                            {1, 3},
                                                            {4, 6},
                                                            {5, 7},
                                                            {0, 1},
                                                            {2, 3},
                                                            {4, 5},
                                                            {6, 7}}};

Eigen::Vector3f CornerPlace(int corner) {
  return {static_cast<float>((corner >> 2) & 1),
          static_cast<float>((corner >> 1) & 1),
          static_cast<float>(corner & 1)};
}

/// The corners of a cell.
struct CellCorners {
  std::array<bool, 8> known;
  std::array<float, 8> distance_m;  ///< 0 if not known.

  bool IsEdgeKnown(const std::array<int, 2>& edge) const {
    return known[static_cast<std::size_t>(edge[0])] && known[static_cast<std::size_t>(edge[1])];
  }

  float At(int corner) const { return distance_m[static_cast<std::size_t>(corner)]; }
};

/// Returns the normalised gradient: along each axis, the mean of the known cell edges.
Eigen::Vector3f CellNormal(const CellCorners& corners) {
  Eigen::Vector3f gradient = Eigen::Vector3f::Zero();
  Eigen::Vector3f count = Eigen::Vector3f::Zero();
  for (std::size_t edge = 0; edge < kCellEdges.size(); ++edge) {
    if (!corners.IsEdgeKnown(kCellEdges[edge])) continue;
    const auto axis = static_cast<Eigen::Index>(edge / 4);
    gradient[axis] += corners.At(kCellEdges[edge][1]) - corners.At(kCellEdges[edge][0]);
    count[axis] += 1.0F;
  }
  gradient.array() /= count.array().max(1.0F);
  const float norm = gradient.norm();
  return norm > 0.0F ? Eigen::Vector3f(gradient / norm) : Eigen::Vector3f::UnitZ();
}

/// Computes the vertex of the cell with lowest corner (`x`, `y`, `z`); false if the surface crosses
/// no edge of the cell between observed voxels.
bool MakeCellVertex(
    const VoxelPatch& patch, float max_jump_m, int x, int y, int z, CellVertex* vertex) {
  CellCorners corners;
  int known = 0;
  int inside = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int cx = x + ((corner >> 2) & 1);
    const int cy = y + ((corner >> 1) & 1);
    const int cz = z + (corner & 1);
    const auto index = static_cast<std::size_t>(corner);
    corners.known[index] = patch.known(cx, cy, cz);
    corners.distance_m[index] = corners.known[index] ? patch.distance_m(cx, cy, cz) : 0.0F;
    if (!corners.known[index]) continue;
    ++known;
    if (corners.distance_m[index] <= 0.0F) ++inside;
  }
  if (inside == 0 || inside == known) return false;

  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  ColorMean color;
  int crossings = 0;
  for (const std::array<int, 2>& edge : kCellEdges) {
    if (!corners.IsEdgeKnown(edge)) continue;
    const auto [low, high] = edge;
    const float low_m = corners.At(low);
    const float high_m = corners.At(high);
    if (!IsCrossing(low_m, high_m, max_jump_m)) continue;
    const float share = low_m / (low_m - high_m);
    sum += CornerPlace(low) + share * (CornerPlace(high) - CornerPlace(low));
    ++crossings;
    if (!patch.has_color()) continue;
    const auto color_at = [&](int corner) {
      return patch.color(x + ((corner >> 2) & 1), y + ((corner >> 1) & 1), z + (corner & 1));
    };
    color.Add(color_at(low), 1.0F - share);
    color.Add(color_at(high), share);
  }
  if (crossings == 0) return false;
  *vertex = {sum / static_cast<float>(crossings), CellNormal(corners), color.mean()};
  return true;
}

// Number of leaves per task of one core: about 200 us of work.
constexpr std::size_t kPartLeaves = 32;

constexpr std::uint32_t kNoVertex = 0xFFFFFFFF;

// Bits of a slab of a leaf's mask: the voxels with y = 0, and those with z = 0.
constexpr std::uint64_t kLowestRow = 0xFF;
constexpr std::uint64_t kLowestColumn = 0x0101010101010101;

/// Index of the vertex of each cell of a leaf.
using CellVertices = std::array<std::uint32_t, kLeafVoxels>;

/// The vertices of some leaves and the quads that start there, the result of one task. Parts are
/// joined in the order of their leaves.
struct MeshPart {
  Mesh mesh;
  bool any_color = false;
  /// By the leaf of the cell's lowest corner, for leaves with vertices. Indices within this part.
  std::vector<std::pair<LeafOrigin, CellVertices>> cells;
  std::uint32_t first_vertex = 0;  ///< Index of the part's first vertex in the joined mesh.
};

/// Builds the mesh leaf by leaf: first all vertices, then the quads between them.
class SurfaceNet {
 public:
  SurfaceNet(const VoxelReader& reader,
             const VoxelScale& scale,
             const Box* box,
             const Cancellation& cancellation)
      : reader_(reader),
        scale_(scale),
        box_(box),
        cancellation_(cancellation),
        max_jump_m_(static_cast<float>(kMaxSurfaceSlope * scale.voxel_size_m)),
        distance_step_m_(scale.distance_step_m()) {}

  Mesh Extract() {
    leaves_.reserve(reader_.leaf_count());
    reader_.VisitLeaves([&](LeafOrigin origin, const LeafView& leaf) {
      leaves_.push_back(origin);
      AddMissingLeavesBelow(origin, leaf);
      return !IsCancelled();
    });
    std::sort(missing_.begin(), missing_.end());
    missing_.erase(std::unique(missing_.begin(), missing_.end()), missing_.end());
    leaves_.insert(leaves_.end(), missing_.begin(), missing_.end());
    parts_.resize((leaves_.size() + kPartLeaves - 1) / kPartLeaves);
    ForEachLeafByParts([this](LeafOrigin origin, MeshPart* part) { AddVertices(origin, part); });
    IndexVertices();
    ForEachLeafByParts([this](LeafOrigin origin, MeshPart* part) { AddQuads(origin, part); });
    return is_cancelled_ ? Mesh{} : JoinParts();
  }

 private:
  struct VertexPlace {
    const CellVertices* cells;
    std::uint32_t first_vertex;
  };

  /// Queries the cancellation until it is set, then returns true without further queries. Any
  /// thread.
  bool IsCancelled() {
    if (!is_cancelled_ && cancellation_.IsCancelled()) is_cancelled_ = true;
    return is_cancelled_;
  }

  /// Calls `add(origin, part)` for every leaf: sequentially within a part, in parallel over the
  /// parts.
  template <typename Add>
  void ForEachLeafByParts(const Add& add) {
    ParallelFor(parts_.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t part = begin; part < end; ++part) {
        const std::size_t end_leaf = std::min(leaves_.size(), (part + 1) * kPartLeaves);
        for (std::size_t leaf = part * kPartLeaves; leaf < end_leaf; ++leaf) {
          if (IsCancelled()) return;
          add(leaves_[leaf], &parts_[part]);
        }
      }
    });
  }

  /// Cells whose lowest corners lie in a leaf that does not exist have vertices, too, if they reach
  /// into an existing one.
  void AddMissingLeavesBelow(LeafOrigin origin, const LeafView& leaf) {
    for (int neighbour = 1; neighbour < 8; ++neighbour) {
      const int below_x = (neighbour >> 2) & 1;
      const int below_y = (neighbour >> 1) & 1;
      const int below_z = neighbour & 1;
      // The voxels of the layers next to the neighbour.
      const std::uint64_t face = (below_y != 0 ? kLowestRow : ~std::uint64_t{0}) &
                                 (below_z != 0 ? kLowestColumn : ~std::uint64_t{0});
      bool is_near = false;
      for (int x = 0; x < (below_x != 0 ? 1 : kLeafSide); ++x) {
        is_near = is_near || (leaf.observed[static_cast<std::size_t>(x)] & face) != 0;
      }
      const LeafOrigin below = {origin.x - below_x * kLeafSide,
                                origin.y - below_y * kLeafSide,
                                origin.z - below_z * kLeafSide};
      if (is_near && !reader_.FindLeaf(below)) missing_.push_back(below);
    }
  }

  void AddVertices(LeafOrigin origin, MeshPart* part) const {
    VoxelPatch patch;
    patch.Load(reader_, distance_step_m_, origin);
    CellVertices* cells = nullptr;
    ForEachVoxelOfLeaf([&](int x, int y, int z) {
      CellVertex vertex;
      if (!MakeCellVertex(patch, max_jump_m_, x, y, z, &vertex)) return;
      const Eigen::Vector3d voxel =
          Eigen::Vector3d(origin.x + x, origin.y + y, origin.z + z) + vertex.place.cast<double>();
      const Eigen::Vector3d point_m = voxel * scale_.voxel_size_m;
      if (box_ != nullptr && !box_->contains(point_m)) return;
      if (cells == nullptr) {
        part->cells.emplace_back().first = origin;
        cells = &part->cells.back().second;
        cells->fill(kNoVertex);
      }
      Mesh& mesh = part->mesh;
      (*cells)[OffsetInLeaf(x, y, z)] = static_cast<std::uint32_t>(mesh.vertices_world.size());
      mesh.vertices_world.emplace_back(point_m.cast<float>());
      mesh.normals_world.push_back(vertex.normal);
      mesh.colors.push_back(vertex.color);
    });
    part->any_color = part->any_color || (cells != nullptr && patch.has_color());
  }

  /// Assigns the indices of the vertices in the joined mesh.
  void IndexVertices() {
    for (MeshPart& part : parts_) {
      part.first_vertex = vertex_count_;
      vertex_count_ += static_cast<std::uint32_t>(part.mesh.vertices_world.size());
      for (const auto& [origin, cells] : part.cells) {
        vertices_.emplace(origin, VertexPlace{&cells, part.first_vertex});
      }
    }
  }

  std::uint32_t VertexAt(std::int32_t x, std::int32_t y, std::int32_t z) const {
    const auto place = vertices_.find(LeafOf(x, y, z));
    if (place == vertices_.end()) return kNoVertex;
    const std::uint32_t index = (*place->second.cells)[OffsetInLeaf(x, y, z)];
    return index == kNoVertex ? kNoVertex : place->second.first_vertex + index;
  }

  void AddQuads(LeafOrigin origin, MeshPart* part) const {
    VoxelPatch patch;
    patch.Load(reader_, distance_step_m_, origin);
    ForEachVoxelOfLeaf([&](int x, int y, int z) {
      if (patch.known(x, y, z)) AddQuadsAt(patch, origin, {x, y, z}, part);
    });
  }

  /// Adds two triangles for every edge with a change of sign from a voxel of this leaf along +x, +y
  /// or +z.
  void AddQuadsAt(const VoxelPatch& patch,
                  LeafOrigin origin,
                  const Eigen::Vector3i& voxel,
                  MeshPart* part) const {
    const float distance_m = patch.distance_m(voxel.x(), voxel.y(), voxel.z());
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3i next = voxel + Eigen::Vector3i::Unit(axis);
      if (!patch.known(next.x(), next.y(), next.z())) continue;
      const float next_m = patch.distance_m(next.x(), next.y(), next.z());
      if (!IsCrossing(distance_m, next_m, max_jump_m_)) continue;
      AddQuad(
          Eigen::Vector3i(origin.x, origin.y, origin.z) + voxel, axis, distance_m <= 0.0F, part);
    }
  }

  /// Adds the quad around the edge from `voxel` along `axis`. `inside` is true if the voxel lies
  /// behind the surface, and determines the winding.
  void AddQuad(const Eigen::Vector3i& voxel, int axis, bool inside, MeshPart* part) const {
    const Eigen::Vector3i side = -Eigen::Vector3i::Unit((axis + 1) % 3);
    const Eigen::Vector3i other = -Eigen::Vector3i::Unit((axis + 2) % 3);
    std::array<std::uint32_t, 4> corners;
    const std::array<Eigen::Vector3i, 4> cells = {
        voxel, voxel + side, voxel + side + other, voxel + other};
    for (std::size_t i = 0; i < 4; ++i) {
      corners[i] = VertexAt(cells[i].x(), cells[i].y(), cells[i].z());
      if (corners[i] == kNoVertex) return;
    }
    if (!inside) std::swap(corners[1], corners[3]);
    part->mesh.triangles.push_back({corners[0], corners[1], corners[2]});
    part->mesh.triangles.push_back({corners[0], corners[2], corners[3]});
  }

  Mesh JoinParts() {
    bool any_color = false;
    std::size_t triangles = 0;
    for (const MeshPart& part : parts_) {
      any_color = any_color || part.any_color;
      triangles += part.mesh.triangles.size();
    }
    Mesh whole;
    whole.vertices_world.reserve(vertex_count_);
    whole.normals_world.reserve(vertex_count_);
    if (any_color) whole.colors.reserve(vertex_count_);
    whole.triangles.reserve(triangles);
    const auto append = [](const auto& from, auto* to) {
      to->insert(to->end(), from.begin(), from.end());
    };
    for (MeshPart& part : parts_) {
      const Mesh mesh = std::exchange(part.mesh, {});
      append(mesh.vertices_world, &whole.vertices_world);
      append(mesh.normals_world, &whole.normals_world);
      if (any_color) append(mesh.colors, &whole.colors);
      append(mesh.triangles, &whole.triangles);
    }
    return whole;
  }

  const VoxelReader& reader_;
  const VoxelScale scale_;
  const Box* box_;
  const Cancellation& cancellation_;
  std::atomic<bool> is_cancelled_ = false;
  float max_jump_m_;
  float distance_step_m_;
  std::vector<LeafOrigin> leaves_;
  std::vector<LeafOrigin> missing_;  ///< Below existing leaves. Appended to `leaves_`.
  std::vector<MeshPart> parts_;
  std::uint32_t vertex_count_ = 0;
  std::unordered_map<LeafOrigin, VertexPlace> vertices_;
};

}  // namespace

Mesh ExtractMesh(const VoxelReader& reader,
                 const VoxelScale& scale,
                 const Box* box,
                 const Cancellation& cancellation) {
  return SurfaceNet(reader, scale, box, cancellation).Extract();
}

}  // namespace steadymap
