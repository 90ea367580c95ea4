// Measures the processing of a frame from decoded images to a committed change set by the pocd
// policy, one thread, 640 x 360 pixels, voxels of 5 cm:
//
//   taskset -c 0 build/release/tests/benchmark/object_mapper_benchmark
//
// Each frame is a commit. The time of an iteration is that of all frames, and the counters are per
// frame; all times are processor time, so that other processes hardly affect them. LargeHall/1 has
// a map of the whole hall, LargeHall/0 of only the 43 objects nearby; both integrate the same
// frames.

#include <algorithm>
#include <cstddef>
#include <ctime>
#include <memory>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include "client/bench/simulator/routes/named_routes.h"
#include "client/bench/simulator/simulation.h"
#include "core/mapper.h"
#include "tests/benchmark/hall_drive.h"

namespace steadymap::benchmarks {
namespace {

MapConfig PocdConfig() {
  MapConfig config;
  config.policy = UpdatePolicy::kPocd;
  return config;
}

/// Returns the processor time of all threads, seconds.
double ProcessorSeconds() {
  return static_cast<double>(std::clock()) / static_cast<double>(CLOCKS_PER_SEC);
}

/// A map with a measurement per frame.
class TimedMap {
 public:
  explicit TimedMap(benchmark::State* state) : state_(state) {}

  void Restore(const MapSnapshot& snapshot) { mapper_->Restore(snapshot); }

  void Take(const Frame& frame) {
    const double start_s = ProcessorSeconds();
    mapper_->Integrate(mapper_->head().Next(), frame);
    MapCommit commit = mapper_->Commit();
    // The previous snapshot is released when the new one is published, as in the service.
    published_ = std::move(commit.snapshot);
    const double took_s = ProcessorSeconds() - start_s;
    frame_ms_.push_back(1e3 * took_s);
    total_s_ += took_s;
  }

  /// Returns the quantile `share` of the times per frame, milliseconds.
  double QuantileMs(double share) const {
    std::vector<double> sorted = frame_ms_;
    std::sort(sorted.begin(), sorted.end());
    return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
  }

  void Report() {
    state_->SetIterationTime(total_s_);
    state_->counters["frames"] = static_cast<double>(frame_ms_.size());
    state_->counters["median_ms"] = QuantileMs(0.5);
    state_->counters["p95_ms"] = QuantileMs(0.95);
    state_->counters["objects"] = static_cast<double>(published_->objects.size());
  }

 private:
  benchmark::State* state_;
  std::unique_ptr<Mapper> mapper_ = Mapper::Create(PocdConfig()).value();
  std::shared_ptr<const MapSnapshot> published_;
  std::vector<double> frame_ms_;
  double total_s_ = 0.0;
};

/// Every frame of route 1-5: a loop through the hall, and another one after goods were moved.
void Route(benchmark::State& state) {
  while (state.KeepRunning()) {
    Simulation simulation(*MakeRoute("1-5"), {});
    TimedMap map(&state);
    for (std::size_t i = 0; i < simulation.frame_count(); ++i) map.Take(simulation.Render(i));
    map.Report();
  }
}

BENCHMARK(Route)->UseManualTime()->Iterations(1)->Unit(benchmark::kSecond);

void LargeHall(benchmark::State& state) {
  static const HallDrive drive = MakeHallDrive({});
  static double nearby_median_ms = 0.0;
  const bool is_whole = state.range(0) != 0;
  while (state.KeepRunning()) {
    TimedMap map(&state);
    map.Restore(is_whole ? drive.whole : drive.nearby);
    for (const Frame& frame : drive.frames) map.Take(frame);
    map.Report();
    if (!is_whole) {
      nearby_median_ms = map.QuantileMs(0.5);
    } else if (nearby_median_ms > 0.0) {
      state.counters["ratio_to_nearby"] = map.QuantileMs(0.5) / nearby_median_ms;
    }
  }
}

BENCHMARK(LargeHall)->Arg(0)->Arg(1)->UseManualTime()->Iterations(1)->Unit(benchmark::kSecond);

}  // namespace
}  // namespace steadymap::benchmarks
