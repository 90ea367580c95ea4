// Measures integration, commit, meshing and packing on real frames, one thread:
//
//   taskset -c 0 build/release/tests/benchmark/tsdf_benchmark
//
// Arguments of each benchmark: voxel size and truncation in millimetres. Every second pixel in both
// directions becomes a surface point (pixel stride 2).

#include <benchmark/benchmark.h>

#include "core/mapper.h"
#include "core/query/vdb_file.h"
#include "core/volume/tsdf_codec.h"
#include "core/volume/tsdf_mesh.h"
#include "tests/benchmark/kitchen_frames.h"

namespace steadymap::benchmarks {
namespace {

constexpr std::size_t kFrames = 300;
constexpr std::size_t kFramesPerCommit = 15;

const std::vector<Frame>& Frames() {
  static const std::vector<Frame> frames = LoadKitchenFrames(kFrames);
  return frames;
}

bool SkipWithoutFrames(benchmark::State& state) {
  if (!Frames().empty()) return false;
  state.SkipWithError("no real frames; set STEADYMAP_SHARED_DATA");
  return true;
}

MapConfig ConfigOf(const benchmark::State& state) {
  MapConfig config;
  config.voxel_size_m = static_cast<double>(state.range(0)) * 1e-3;
  config.truncation_m = static_cast<double>(state.range(1)) * 1e-3;
  return config;
}

std::shared_ptr<const MapSnapshot> MapAll(const MapConfig& config) {
  const std::unique_ptr<Mapper> mapper = Mapper::Create(config).value();
  for (const Frame& frame : Frames()) mapper->Integrate(mapper->head().Next(), frame);
  return mapper->Commit().snapshot;
}

/// Integrates one frame into a map of the whole sequence, including the copies caused by commits.
void IntegrateFrame(benchmark::State& state) {
  if (SkipWithoutFrames(state)) return;
  std::unique_ptr<Mapper> mapper = Mapper::Create(ConfigOf(state)).value();
  std::size_t next = 0;
  while (state.KeepRunning()) {
    mapper->Integrate(mapper->head().Next(), Frames()[next]);
    if (++next % kFramesPerCommit != 0) continue;
    state.PauseTiming();
    mapper->Commit();
    if (next == Frames().size()) {
      mapper = Mapper::Create(ConfigOf(state)).value();
      next = 0;
    }
    state.ResumeTiming();
  }
}

BENCHMARK(IntegrateFrame)
    ->Args({50, 150})
    ->Args({20, 80})
    ->Args({10, 40})
    ->Unit(benchmark::kMillisecond);

/// Packs the changes of 15 frames.
void Commit(benchmark::State& state) {
  if (SkipWithoutFrames(state)) return;
  std::unique_ptr<Mapper> mapper = Mapper::Create(ConfigOf(state)).value();
  std::size_t next = 0;
  std::size_t bytes = 0;
  std::size_t leaves = 0;
  while (state.KeepRunning()) {
    state.PauseTiming();
    for (std::size_t i = 0; i < kFramesPerCommit; ++i) {
      mapper->Integrate(mapper->head().Next(), Frames()[next]);
      next = (next + 1) % Frames().size();
    }
    state.ResumeTiming();
    const MapCommit commit = mapper->Commit();
    state.PauseTiming();
    leaves += commit.delta.leaves.size();
    for (const LeafChange& leaf : commit.delta.leaves) bytes += leaf.packed.size();
    state.ResumeTiming();
  }
  state.counters["bytes_per_leaf"] = static_cast<double>(bytes) / static_cast<double>(leaves);
  state.counters["leaves"] =
      benchmark::Counter(static_cast<double>(leaves), benchmark::Counter::kAvgIterations);
}

BENCHMARK(Commit)->Args({50, 150})->Args({10, 40})->Unit(benchmark::kMillisecond);

double SurfaceArea(const Mesh& mesh) {
  double area_m2 = 0.0;
  for (const std::array<std::uint32_t, 3>& triangle : mesh.triangles) {
    const Eigen::Vector3f a = mesh.vertices_world[triangle[0]];
    const Eigen::Vector3f b = mesh.vertices_world[triangle[1]];
    const Eigen::Vector3f c = mesh.vertices_world[triangle[2]];
    area_m2 += 0.5 * static_cast<double>((b - a).cross(c - a).norm());
  }
  return area_m2;
}

/// Extracts the mesh of the whole map; also reports memory and packed bytes per square metre.
void ExtractWholeMesh(benchmark::State& state) {
  if (SkipWithoutFrames(state)) return;
  const std::shared_ptr<const MapSnapshot> map = MapAll(ConfigOf(state));
  Mesh mesh;
  while (state.KeepRunning()) mesh = ExtractMesh(map->background, map->scale, nullptr);
  std::size_t packed_bytes = 0;
  map->background.ForEachLeaf(
      [&](LeafOrigin, const LeafView& leaf) { packed_bytes += PackLeaf(leaf).size(); });
  const double area_m2 = SurfaceArea(mesh);
  state.counters["triangles"] = static_cast<double>(mesh.triangles.size());
  state.counters["memory_MB_per_m2"] =
      static_cast<double>(map->background.memory_bytes()) * 1e-6 / area_m2;
  state.counters["packed_MB_per_m2"] = static_cast<double>(packed_bytes) * 1e-6 / area_m2;
}

BENCHMARK(ExtractWholeMesh)->Args({50, 150})->Args({20, 80})->Unit(benchmark::kMillisecond);

void WriteWholeVdb(benchmark::State& state) {
  if (SkipWithoutFrames(state)) return;
  const std::shared_ptr<const MapSnapshot> map = MapAll(ConfigOf(state));
  while (state.KeepRunning()) benchmark::DoNotOptimize(WriteVdb(*map, nullptr));
}

BENCHMARK(WriteWholeVdb)->Args({50, 150})->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace steadymap::benchmarks
