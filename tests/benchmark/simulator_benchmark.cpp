#include <cstddef>
#include <string>

#include <benchmark/benchmark.h>

#include "client/bench/simulator/routes/named_routes.h"
#include "client/bench/simulator/simulated_frame_source.h"
#include "client/bench/simulator/simulation.h"

namespace steadymap {
namespace {

SimulationOptions Options(bool is_ideal) {
  SimulationOptions options;
  options.sensor = is_ideal ? SensorModel::Ideal() : SensorModel::Full();
  return options;
}

// Renders one frame of 640 x 360: rays, depth noise, labels and label noise.
void RenderFrame(benchmark::State& state, const std::string& route, bool is_ideal) {
  Simulation simulation(*MakeRoute(route), Options(is_ideal));
  // A step that covers all parts of the route before it repeats a frame.
  const std::size_t step = simulation.frame_count() / 31 + 1;
  std::size_t index = 0;
  while (state.KeepRunning()) {
    benchmark::DoNotOptimize(simulation.Render(index));
    index = (index + step) % simulation.frame_count();
  }
  state.SetItemsProcessed(state.iterations());
}

void RenderFrameInColor(benchmark::State& state) {
  SimulationOptions options = Options(false);
  options.include_color = true;
  options.include_instances = true;
  Simulation simulation(*MakeRoute("baseline"), options);
  std::size_t index = 0;
  while (state.KeepRunning()) {
    benchmark::DoNotOptimize(simulation.Render(index));
    index = (index + 13) % simulation.frame_count();
  }
}

void PackFrame(benchmark::State& state) {
  Simulation simulation(*MakeRoute("baseline"), Options(false));
  const Frame frame = simulation.Render(100);
  std::size_t bytes = 0;
  while (state.KeepRunning()) bytes = PackSimulatedFrame(frame).ByteSizeLong();
  state.counters["bytes"] = static_cast<double>(bytes);
}

BENCHMARK_CAPTURE(RenderFrame, torwic_ideal, "baseline", true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(RenderFrame, torwic_full_noise, "baseline", false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(RenderFrame, hall_ideal, "hall", true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(RenderFrame, hall_full_noise, "hall", false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(RenderFrame, people_full_noise, "people", false)->Unit(benchmark::kMillisecond);
BENCHMARK(RenderFrameInColor)->Unit(benchmark::kMillisecond);
BENCHMARK(PackFrame)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace steadymap
