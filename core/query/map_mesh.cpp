#include "core/query/map_mesh.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

#include "core/types/parallel.h"
#include "core/volume/tsdf_mesh.h"

namespace steadymap {
namespace {

constexpr std::uint32_t kDropped = std::numeric_limits<std::uint32_t>::max();

// Number of volumes meshed in parallel: enough for all cores.
constexpr std::size_t kVolumesAtOnce = 32;

/// Transforms a mesh from the frame of its volume to the world frame.
void Place(const Eigen::Isometry3f& T_world_volume, Mesh* mesh) {
  for (Eigen::Vector3f& vertex : mesh->vertices_world) vertex = T_world_volume * vertex;
  for (Eigen::Vector3f& normal : mesh->normals_world) normal = T_world_volume.linear() * normal;
}

/// Drops the vertices outside the box and the triangles with such a vertex.
void Clip(const Box& box, Mesh* mesh) {
  Mesh kept;
  std::vector<std::uint32_t> place(mesh->vertices_world.size(), kDropped);
  for (std::size_t i = 0; i < place.size(); ++i) {
    if (!box.contains(mesh->vertices_world[i].cast<double>())) continue;
    place[i] = static_cast<std::uint32_t>(kept.vertices_world.size());
    kept.vertices_world.push_back(mesh->vertices_world[i]);
    kept.normals_world.push_back(mesh->normals_world[i]);
    if (!mesh->colors.empty()) kept.colors.push_back(mesh->colors[i]);
  }
  for (const std::array<std::uint32_t, 3>& triangle : mesh->triangles) {
    const std::array<std::uint32_t, 3> moved = {
        place[triangle[0]], place[triangle[1]], place[triangle[2]]};
    if (moved[0] == kDropped || moved[1] == kDropped || moved[2] == kDropped) continue;
    kept.triangles.push_back(moved);
  }
  *mesh = std::move(kept);
}

void Append(const Mesh& part, Mesh* whole) {
  const auto first = static_cast<std::uint32_t>(whole->vertices_world.size());
  if (!part.colors.empty()) whole->colors.resize(first, kUnknownColor);
  const auto append = [](const auto& from, auto* to) {
    to->insert(to->end(), from.begin(), from.end());
  };
  append(part.vertices_world, &whole->vertices_world);
  append(part.normals_world, &whole->normals_world);
  append(part.colors, &whole->colors);
  if (!whole->colors.empty()) whole->colors.resize(whole->vertices_world.size(), kUnknownColor);
  for (const std::array<std::uint32_t, 3>& triangle : part.triangles) {
    whole->triangles.push_back({triangle[0] + first, triangle[1] + first, triangle[2] + first});
  }
}

/// Extracts the surface of one volume, world frame.
Mesh ExtractPart(const PlacedVolume& volume,
                 const VoxelScale& scale,
                 const Box* box_world,
                 const Cancellation& cancellation) {
  if (volume.object == nullptr) return ExtractMesh(*volume.voxels, scale, box_world, cancellation);
  if (box_world != nullptr && !box_world->intersects(BoundsOf(volume, scale.truncation_m))) {
    return {};
  }
  Mesh part = ExtractMesh(*volume.voxels, scale, nullptr, cancellation);
  Place(volume.T_world_volume.cast<float>(), &part);
  if (box_world != nullptr) Clip(*box_world, &part);
  return part;
}

}  // namespace

Mesh ExtractMapMesh(std::span<const PlacedVolume> volumes,
                    const VoxelScale& scale,
                    const Box* box_world,
                    const Cancellation& cancellation) {
  Mesh mesh;
  std::array<Mesh, kVolumesAtOnce> parts;
  for (std::size_t first = 0; first < volumes.size(); first += kVolumesAtOnce) {
    if (cancellation.IsCancelled()) return {};
    const auto group = volumes.subspan(first, std::min(kVolumesAtOnce, volumes.size() - first));
    ParallelFor(group.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        parts[i] = ExtractPart(group[i], scale, box_world, cancellation);
      }
    });
    for (std::size_t i = 0; i < group.size(); ++i) Append(parts[i], &mesh);
  }
  return mesh;
}

}  // namespace steadymap
