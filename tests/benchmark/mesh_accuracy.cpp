// Measures the accuracy of the mesh of the real kitchen:
//
//   build/release/tests/benchmark/mesh_accuracy
//
// Prints, for maps of 5 and 2 cm voxels: the share of the mesh's vertices within 1.5 voxels of a
// raw back-projected point, the share of the mesh within 2 cm of a reference, and the share of the
// reference within 5 cm of the mesh. The reference is our own mesh at 1 cm voxels.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <unordered_map>

#include "core/mapper.h"
#include "core/volume/tsdf_mesh.h"
#include "tests/benchmark/kitchen_frames.h"

namespace steadymap::benchmarks {
namespace {

constexpr std::size_t kFrames = 300;
constexpr float kMaxDepthM = 3.0F;

/// Points in cubic buckets, for distances up to a bucket's side.
class PointBuckets {
 public:
  explicit PointBuckets(float side_m) : side_m_(side_m) {}

  void Add(const Eigen::Vector3f& point) { buckets_[KeyOf(BucketOf(point))].push_back(point); }

  bool IsEmptyAround(const Eigen::Vector3f& point) const {
    return buckets_.find(KeyOf(BucketOf(point))) == buckets_.end();
  }

  /// True if a point lies within `distance_m`, at most a bucket's side.
  bool HasWithin(const Eigen::Vector3f& point, float distance_m) const {
    const Eigen::Vector3i center = BucketOf(point);
    for (int i = 0; i < 27; ++i) {
      const Eigen::Vector3i offset(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1);
      const auto bucket = buckets_.find(KeyOf(center + offset));
      if (bucket == buckets_.end()) continue;
      for (const Eigen::Vector3f& other : bucket->second) {
        if ((other - point).squaredNorm() < distance_m * distance_m) return true;
      }
    }
    return false;
  }

 private:
  Eigen::Vector3i BucketOf(const Eigen::Vector3f& point) const {
    return (point / side_m_).array().floor().cast<int>();
  }

  static std::uint64_t KeyOf(const Eigen::Vector3i& bucket) {
    constexpr int kBias = 1 << 20;
    return static_cast<std::uint64_t>(bucket.x() + kBias) << 42 |
           static_cast<std::uint64_t>(bucket.y() + kBias) << 21 |
           static_cast<std::uint64_t>(bucket.z() + kBias);
  }

  float side_m_;
  std::unordered_map<std::uint64_t, std::vector<Eigen::Vector3f>> buckets_;
};

Mesh MapMesh(const std::vector<Frame>& frames, double voxel_size_m, double truncation_m) {
  MapConfig config;
  config.voxel_size_m = voxel_size_m;
  config.truncation_m = truncation_m;
  config.max_depth_m = static_cast<double>(kMaxDepthM);
  const std::unique_ptr<Mapper> mapper = Mapper::Create(config).value();
  for (const Frame& frame : frames) mapper->Integrate(mapper->head().Next(), frame);
  const MapCommit commit = mapper->Commit();
  return ExtractMesh(commit.snapshot->background, commit.snapshot->scale, nullptr);
}

/// Samples the mesh's triangles with points at most `spacing_m` apart along their edges.
std::vector<Eigen::Vector3f> SampleSurface(const Mesh& mesh, float spacing_m) {
  std::vector<Eigen::Vector3f> samples;
  for (const std::array<std::uint32_t, 3>& triangle : mesh.triangles) {
    const Eigen::Vector3f a = mesh.vertices_world[triangle[0]];
    const Eigen::Vector3f ab = mesh.vertices_world[triangle[1]] - a;
    const Eigen::Vector3f ac = mesh.vertices_world[triangle[2]] - a;
    const int steps = 1 + static_cast<int>(std::max(ab.norm(), ac.norm()) / spacing_m);
    for (int i = 0; i <= steps; ++i) {
      for (int j = 0; i + j <= steps; ++j) {
        const float share_b = static_cast<float>(i) / static_cast<float>(steps);
        const float share_c = static_cast<float>(j) / static_cast<float>(steps);
        samples.emplace_back(a + share_b * ab + share_c * ac);
      }
    }
  }
  return samples;
}

/// Returns the raw points of every third pixel and frame, thinned to one per centimetre.
PointBuckets RawPoints(const std::vector<Frame>& frames) {
  PointBuckets thinned(0.01F);
  PointBuckets points(0.1F);
  for (std::size_t i = 0; i < frames.size(); i += 3) {
    const Frame& frame = frames[i];
    for (int v = 0; v < frame.camera.height_px; v += 3) {
      for (int u = 0; u < frame.camera.width_px; u += 3) {
        const std::uint16_t units = frame.depth.units.At(u, v);
        const double depth_m = units * frame.depth.metres_per_unit;
        if (units == kNoDepth || depth_m > static_cast<double>(kMaxDepthM)) continue;
        const Eigen::Vector3f point =
            (frame.T_world_camera * (depth_m * frame.camera.Ray(u, v))).cast<float>();
        if (!thinned.IsEmptyAround(point)) continue;
        thinned.Add(point);
        points.Add(point);
      }
    }
  }
  return points;
}

double ShareWithin(const std::vector<Eigen::Vector3f>& points,
                   const PointBuckets& others,
                   float distance_m) {
  std::size_t near = 0;
  for (const Eigen::Vector3f& point : points) near += others.HasWithin(point, distance_m) ? 1 : 0;
  return 100.0 * static_cast<double>(near) / static_cast<double>(points.size());
}

int Run() {
  const std::vector<Frame> frames = LoadKitchenFrames(kFrames);
  if (frames.empty()) {
    std::fprintf(stderr, "mesh_accuracy: no real frames; set STEADYMAP_SHARED_DATA\n");
    return EXIT_FAILURE;
  }
  const PointBuckets raw = RawPoints(frames);
  const std::vector<Eigen::Vector3f> reference_samples =
      SampleSurface(MapMesh(frames, 0.01, 0.04), 0.004F);
  PointBuckets reference(0.1F);
  for (const Eigen::Vector3f& sample : reference_samples) reference.Add(sample);
  std::printf("voxel   within 1.5 voxels of raw   within 2 cm of 1 cm mesh   1 cm mesh covered\n");
  for (const auto& [voxel_size_m, truncation_m] : {std::pair{0.05, 0.15}, {0.02, 0.08}}) {
    const Mesh mesh = MapMesh(frames, voxel_size_m, truncation_m);
    const auto voxel_m = static_cast<float>(voxel_size_m);
    const std::vector<Eigen::Vector3f> samples = SampleSurface(mesh, 0.25F * voxel_m);
    PointBuckets surface(0.1F);
    for (const Eigen::Vector3f& sample : samples) surface.Add(sample);
    std::printf("%2.0f cm   %23.1f %%   %23.1f %%   %15.1f %%\n",
                100.0 * voxel_size_m,
                ShareWithin(mesh.vertices_world, raw, 1.5F * voxel_m),
                ShareWithin(samples, reference, 0.02F),
                ShareWithin(reference_samples, surface, 0.05F));
  }
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace steadymap::benchmarks

int main() { return steadymap::benchmarks::Run(); }
