// Measures the cost of one frame, over frames and maps at the limits of the service:
//
//   build/release/tests/benchmark/frame_bound_sweep --frames 500
//
// `--only "thing a block"` runs only the cases with these words in their description. Each case
// runs in its own process, for at most a minute: it checks the frame as an upload does and, if it
// is accepted, integrates it three times into one map. Prints the most expensive cases by processor
// time and by memory, including the images. Fails if a case did not end or needed more than 1 GB.

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/integration/frame_work.h"
#include "core/mapper.h"
#include "tests/support/legal_frame.h"

namespace steadymap {
namespace {

constexpr unsigned kLongestCaseS = 60;
constexpr double kMostMb = 1000.0;
constexpr int kTimesIntegrated = 3;
constexpr int kRefused = 3;

struct CaseCost {
  std::string description;
  bool is_refused = false;
  bool has_ended = false;
  double processor_s = 0.0;
  double peak_mb = 0.0;
};

double SecondsOf(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

/// Runs one case in the child process. Returns its exit status.
int Integrate(const LegalFrame& legal) {
  const KnownLabels labels(legal.config.classes);
  auto mapper = Mapper::Create(legal.config);
  if (!mapper.ok() || !ValidateFrame(legal.frame, labels).ok()) return EXIT_FAILURE;
  if (!CheckFrameWork(legal.frame, legal.config).ok()) return kRefused;
  Frame frame = legal.frame;
  for (int i = 0; i < kTimesIntegrated; ++i) {
    // The robot moves by 2 cm.
    frame.T_world_camera.translate(Eigen::Vector3d(0.02, 0.0, 0.0));
    frame.capture_time = Timestamp::FromSeconds(0.1 * (i + 1));
    (*mapper)->Integrate((*mapper)->head().Next(), frame);
    (*mapper)->Commit();
  }
  return EXIT_SUCCESS;
}

CaseCost Measure(std::uint64_t seed, const LegalFrame& legal) {
  CaseCost cost;
  cost.description = "seed " + std::to_string(seed) + ": " + legal.description;
  const pid_t child = fork();
  if (child == 0) {
    alarm(kLongestCaseS);
    _exit(Integrate(legal));
  }
  int status = 0;
  rusage usage{};
  if (child < 0 || wait4(child, &status, 0, &usage) != child) std::terminate();
  cost.has_ended = WIFEXITED(status) && WEXITSTATUS(status) != EXIT_FAILURE;
  cost.is_refused = WIFEXITED(status) && WEXITSTATUS(status) == kRefused;
  cost.processor_s = SecondsOf(usage.ru_utime) + SecondsOf(usage.ru_stime);
  cost.peak_mb = static_cast<double>(usage.ru_maxrss) * 1024e-6;
  return cost;
}

template <typename Key>
void PrintMostExpensive(const char* title,
                        std::vector<CaseCost> costs,
                        std::size_t count,
                        Key key) {
  std::sort(costs.begin(), costs.end(), [&](const CaseCost& a, const CaseCost& b) {
    return key(a) > key(b);
  });
  std::printf("\n%s\n%9s %8s\n", title, "CPU s", "peak MB");
  for (std::size_t i = 0; i < std::min(count, costs.size()); ++i) {
    std::printf("%9.2f %8.0f %s %s\n",
                costs[i].processor_s,
                costs[i].peak_mb,
                !costs[i].has_ended ? "NOT ENDED" : (costs[i].is_refused ? "refused" : "taken"),
                costs[i].description.c_str());
  }
}

int Main(int argc, char** argv) {
  CLI::App app("Measures the cost of one frame at the limits of the service.");
  int frames = 500;
  int max_side_px = 4096;
  std::uint64_t first = 0;
  std::string only;
  app.add_option("--frames", frames, "Number of cases")->capture_default_str();
  app.add_option("--first", first, "Seed of the first case")->capture_default_str();
  app.add_option("--max-side", max_side_px, "Largest side of an image, px")->capture_default_str();
  app.add_option("--only", only, "Only cases with this text in their description");
  CLI11_PARSE(app, argc, argv);
  std::vector<CaseCost> costs;
  std::size_t refused = 0;
  std::size_t endless = 0;
  std::size_t too_large = 0;
  for (int i = 0; i < frames; ++i) {
    const std::uint64_t seed = first + static_cast<std::uint64_t>(i);
    const LegalFrame legal = RandomLegalFrame(seed, max_side_px);
    if (legal.description.find(only) == std::string::npos) continue;
    costs.push_back(Measure(seed, legal));
    refused += costs.back().is_refused ? 1 : 0;
    endless += costs.back().has_ended ? 0 : 1;
    too_large += costs.back().peak_mb > kMostMb ? 1 : 0;
  }
  std::printf("%zu cases: %zu refused, %zu not ended, %zu beyond %.0f MB\n",
              costs.size(),
              refused,
              endless,
              too_large,
              kMostMb);
  PrintMostExpensive("by time", costs, 12, [](const CaseCost& cost) { return cost.processor_s; });
  PrintMostExpensive("by memory", costs, 12, [](const CaseCost& cost) { return cost.peak_mb; });
  return endless + too_large == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}

}  // namespace
}  // namespace steadymap

int main(int argc, char** argv) { return steadymap::Main(argc, argv); }
