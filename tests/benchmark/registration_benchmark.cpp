// Measures the registration of 43 observations to 43 objects, one thread, 2 000 to 5 000 points
// each:
//
//   taskset -c 0 build/release/tests/benchmark/registration_benchmark
//
// The argument of FortyThreePairs is the number of objects that moved by up to 15 cm and 8 degrees;
// the others are in place, observed with 3 mm of noise.

#include <random>
#include <vector>

#include <benchmark/benchmark.h>

#include "core/registration/registration.h"
#include "tests/support/analytic_solid.h"

namespace steadymap::benchmarks {
namespace {

using ::steadymap::testing::LooksAround;
using ::steadymap::testing::MakeVolume;
using ::steadymap::testing::RandomMotionAbout;
using ::steadymap::testing::Solid;
using ::steadymap::testing::SurfaceView;
using ::steadymap::testing::ThingsToLookAt;
using ::steadymap::testing::WithNoise;

constexpr VoxelScale kScale{0.05, 0.15};
constexpr std::size_t kPairs = 43;
constexpr double kNoiseM = 0.003;

/// An object and its observation.
struct Pair {
  TsdfGrid volume;
  UprightPose T_world_object;
  std::vector<Eigen::Vector3d> points_world;
};

std::vector<Pair> MakePairs(std::size_t moved) {
  // Between 2 000 and 5 000 points, depending on the solid and the view.
  constexpr double kSpacingRad = 0.007;
  std::mt19937_64 random(1);
  const std::vector<Solid> solids = ThingsToLookAt();
  std::vector<std::vector<SurfaceView>> views;
  views.reserve(solids.size());
  for (const Solid& solid : solids) views.push_back(LooksAround(solid, kSpacingRad));
  std::vector<Pair> pairs;
  pairs.reserve(kPairs);
  for (std::size_t i = 0; i < kPairs; ++i) {
    const std::size_t which = i % solids.size();
    const SurfaceView& view = views[which][i % views[which].size()];
    Pair pair{MakeVolume(solids[which], kScale),
              {{2.0 * static_cast<double>(i), 3.0, 0.0}, 0.1 * static_cast<double>(i)},
              WithNoise(view, kNoiseM, &random)};
    const Eigen::Isometry3d T_world_grid = pair.T_world_object.ToIsometry();
    const Eigen::Isometry3d motion = RandomMotionAbout(pair.T_world_object.position_world, &random);
    // Distributes the moved objects evenly over the shapes.
    const bool moves = i * moved / kPairs != (i + 1) * moved / kPairs;
    for (Eigen::Vector3d& point : pair.points_world) {
      point = T_world_grid * point;
      if (moves) point = motion * point;
    }
    pairs.push_back(std::move(pair));
  }
  return pairs;
}

/// Registers the points of each pair to the volume of the pair `ahead` places later.
void RegisterAll(benchmark::State& state, const std::vector<Pair>& pairs, std::size_t ahead) {
  std::size_t points = 0;
  std::size_t unmoved = 0;
  while (state.KeepRunning()) {
    points = 0;
    unmoved = 0;
    for (std::size_t i = 0; i < kPairs; ++i) {
      const Registration registration = RegisterPoints(pairs[i].points_world,
                                                       pairs[(i + ahead) % kPairs].volume,
                                                       kScale,
                                                       pairs[i].T_world_object);
      benchmark::DoNotOptimize(registration);
      points += pairs[i].points_world.size();
      if (registration.iterations == 0) ++unmoved;
    }
  }
  state.counters["points_a_pair"] = static_cast<double>(points) / static_cast<double>(kPairs);
  state.counters["accepted_unmoved"] = static_cast<double>(unmoved);
}

void FortyThreePairs(benchmark::State& state) {
  RegisterAll(state, MakePairs(static_cast<std::size_t>(state.range(0))), 0);
}

/// The most expensive case: the observed surface never matches the mapped one.
void FortyThreeStrangers(benchmark::State& state) { RegisterAll(state, MakePairs(0), 1); }

BENCHMARK(FortyThreePairs)->Arg(0)->Arg(4)->Arg(13)->Arg(43)->Unit(benchmark::kMillisecond);
BENCHMARK(FortyThreeStrangers)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace steadymap::benchmarks
