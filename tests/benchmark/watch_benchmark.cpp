// Measures the effect of watchers on the upload of frames, and the content they receive, through
// gRPC on loopback; the daemon, the robot and the watchers share the machine:
//
//   build/release/tests/benchmark/watch_benchmark
//   build/release/tests/benchmark/watch_benchmark --case 100:box --rounds 5 --rate 0
//
// A case is COUNT[:FILTER[:STALLED]]: number of watchers, their filter (all, events, objects, box:
// one common box, boxes: one per watcher, class), and number of watchers that stop reading. Each
// run has its own daemon and an empty map; runs without watchers alternate with runs with watchers,
// and every value is the median of its rounds. `behind` is the longest delay of any watcher after
// the first report of a revision, `commits` the largest number of commits in one step, `daemon MB`
// the peak of the daemon's resident memory, `growth` its difference to the run without watchers.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <map>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <sys/resource.h>

#include "client/bench/simulator/routes/named_routes.h"
#include "client/bench/simulator/scene/scene.h"
#include "client/map/map_client.h"
#include "client/transport/channel.h"
#include "tests/benchmark/frame_feed.h"
#include "tests/benchmark/process_usage.h"
#include "tests/benchmark/watch_crowd.h"
#include "tests/benchmark/watch_figures.h"
#include "tests/support/daemon_process.h"
#include "tests/support/temporary_folder.h"

namespace steadymap::benchmarks {
namespace {

constexpr std::chrono::seconds kCatchUpLimit{60};

struct Options {
  std::string route = "1-5";
  int policy = v1::UPDATE_POLICY_POCD;
  double rate_hz = 30.0;
  std::size_t frames = 300;
  std::size_t rounds = 3;
  std::size_t connections = 8;
  std::vector<std::string> cases{"1",
                                 "10",
                                 "100",
                                 "100:events",
                                 "100:box",
                                 "100:boxes",
                                 "100:class",
                                 "100:all:50",
                                 "1000:events"};
};

struct Case {
  std::string name;
  std::size_t watchers = 0;
  std::string filter = "all";
  std::size_t stalled = 0;
};

Case ParseCase(const std::string& text) {
  Case parsed;
  parsed.name = text;
  const std::size_t colon = text.find(':');
  parsed.watchers = std::stoul(text.substr(0, colon));
  if (colon == std::string::npos) return parsed;
  const std::size_t second = text.find(':', colon + 1);
  parsed.filter = text.substr(colon + 1, second - colon - 1);
  if (second != std::string::npos) parsed.stalled = std::stoul(text.substr(second + 1));
  return parsed;
}

/// Adds a box of 2 m in the robot's lane, shifted slightly for each watcher.
void AddBox(std::size_t place, v1::WatchFilter* filter) {
  v1::Box* box = filter->add_boxes();
  const double shift_m = 0.05 * static_cast<double>(place % 100);
  box->mutable_min_m()->set_x(-3.0 + shift_m);
  box->mutable_min_m()->set_y(1.5);
  box->mutable_min_m()->set_z(-0.5);
  box->mutable_max_m()->set_x(-1.0 + shift_m);
  box->mutable_max_m()->set_y(3.5);
  box->mutable_max_m()->set_z(2.0);
}

v1::WatchFilter MakeFilter(const std::string& name, std::size_t place) {
  v1::WatchFilter filter;
  if (name == "all") return filter;
  if (name == "events" || name == "objects") {
    filter.add_kinds(v1::WATCH_KIND_EVENTS);
    if (name == "objects") filter.add_kinds(v1::WATCH_KIND_OBJECTS);
  } else if (name == "box") {
    AddBox(0, &filter);
  } else if (name == "boxes") {
    AddBox(place, &filter);
  } else if (name == "class") {
    filter.add_class_ids(static_cast<std::uint32_t>(SceneClass::kGoods));
  } else {
    throw std::runtime_error("unknown filter \"" + name + "\"");
  }
  return filter;
}

std::vector<WatcherPlan> MakePlans(const Case& watched, const std::string& map) {
  std::vector<WatcherPlan> plans(watched.watchers);
  for (std::size_t i = 0; i < plans.size(); ++i) {
    plans[i].request.set_map(map);
    plans[i].request.set_start(v1::WATCH_START_SNAPSHOT_THEN_FOLLOW);
    plans[i].request.set_takes_patches(true);
    *plans[i].request.mutable_filter() = MakeFilter(watched.filter, i);
    const std::size_t stalled_before = i * watched.stalled / plans.size();
    const bool stalls = (i + 1) * watched.stalled / plans.size() != stalled_before;
    // Staggered, so that each holds another revision.
    if (stalls) plans[i].stalls_after = 1 + 2 * stalled_before;
  }
  return plans;
}

/// Returns the bytes of the whole map for a watcher that starts with a snapshot.
double SnapshotBytes(const std::string& address, const MapName& map, std::uint64_t revision) {
  WatcherPlan plan;
  plan.request.set_map(map.ToString());
  plan.request.set_start(v1::WATCH_START_SNAPSHOT_THEN_FOLLOW);
  plan.request.set_takes_patches(true);
  WatchCrowd crowd(address, 1, {plan});
  crowd.AwaitRevision(revision, kCatchUpLimit);
  const std::vector<WatcherRecord> records = crowd.Finish();
  return records[0].steps.empty() ? 0.0 : static_cast<double>(records[0].steps[0].bytes);
}

/// Values by name, in the order of the table's columns.
using Figures = std::map<std::string, double>;

double OwnProcessorSeconds() { return UsageOf(getpid()).processor_s; }

Figures RunOnce(const Options& options, const Case& watched, const std::vector<v1::Frame>& frames) {
  const TemporaryFolder folder;
  DaemonProcess daemon(folder.path());
  daemon.AwaitServing();
  const auto channel = OpenChannel(daemon.address());
  const MapName map{"default", "hall"};
  v1::MapConfig config;
  config.set_policy(static_cast<v1::UpdatePolicy>(options.policy));
  if (const auto made = MapClient(channel).CreateMap(map, config); !made.ok()) {
    throw std::runtime_error(made.status().ToString());
  }
  WatchCrowd crowd(daemon.address(), options.connections, MakePlans(watched, map.ToString()));
  const double processor_s = UsageOf(daemon.process()).processor_s;
  const double own_s = OwnProcessorSeconds();
  const FeedRecord feed = FeedFrames(daemon.address(), map, frames, options.rate_hz);
  if (!crowd.AwaitRevision(frames.size(), kCatchUpLimit)) std::printf("some did not catch up\n");
  const ProcessUsage usage = UsageOf(daemon.process());
  const double own_used_s = OwnProcessorSeconds() - own_s;
  const std::vector<WatcherRecord> records = crowd.Finish();
  for (const WatcherRecord& record : records) {
    if (!record.end.empty()) std::printf("a watch %s\n", record.end.c_str());
  }
  const WatchFigures seen = MeasureWatch(feed, records);
  const auto count = static_cast<double>(frames.size());
  return {{"frames_s", feed.frames_per_second()},
          {"behind_s", seen.most_behind_s},
          {"commits", static_cast<double>(seen.most_commits_a_step)},
          {"latency_s", seen.median_latency_s},
          {"latency95_s", seen.p95_latency_s},
          {"bytes", seen.bytes_a_frame},
          {"snapshot", SnapshotBytes(daemon.address(), map, frames.size())},
          {"memory_mb", usage.peak_resident_mb},
          {"daemon_ms", 1e3 * (usage.processor_s - processor_s) / count},
          {"clients_ms", 1e3 * own_used_s / count}};
}

double Median(const std::vector<Figures>& rounds, const std::string& name) {
  std::vector<double> values;
  values.reserve(rounds.size());
  for (const Figures& round : rounds) values.push_back(round.at(name));
  return Quantile(std::move(values), 0.5);
}

void PrintHeader() {
  std::printf("%-14s %9s %7s %8s %7s %9s %8s %9s %8s %7s %8s %8s %8s %8s\n",
              "watchers",
              "frames/s",
              "ratio",
              "behind s",
              "commits",
              "median ms",
              "p95 ms",
              "kB/frame",
              "delta %",
              "map MB",
              "daemonMB",
              "growthMB",
              "daemon",
              "clients");
  std::printf("%102s %8s %8s %8s\n", "", "", "ms/frame", "ms/frame");
}

void PrintCase(const std::string& name,
               const std::vector<Figures>& without,
               const std::vector<Figures>& with,
               double frame_bytes) {
  std::vector<double> ratios;
  std::vector<double> growths;
  for (std::size_t i = 0; i < with.size(); ++i) {
    ratios.push_back(with[i].at("frames_s") / without[i].at("frames_s"));
    growths.push_back(with[i].at("memory_mb") - without[i].at("memory_mb"));
  }
  const double bytes = Median(with, "bytes");
  std::printf(
      "%-14s %9.1f %7.3f %8.3f %7.0f %9.0f %8.0f %9.2f %8.2f %7.2f %8.1f %8.1f %8.2f %8.2f\n",
      name.c_str(),
      Median(with, "frames_s"),
      Quantile(ratios, 0.5),
      Median(with, "behind_s"),
      Median(with, "commits"),
      1e3 * Median(with, "latency_s"),
      1e3 * Median(with, "latency95_s"),
      1e-3 * bytes,
      100.0 * bytes / frame_bytes,
      1e-6 * Median(with, "snapshot"),
      Median(with, "memory_mb"),
      Quantile(growths, 0.5),
      Median(with, "daemon_ms"),
      Median(with, "clients_ms"));
  std::fflush(stdout);
}

void Run(const Options& options) {
  SimulationOptions simulation;
  simulation.sensor = SensorModel::Full();
  auto route = MakeRoute(options.route);
  if (!route.ok()) throw std::runtime_error(route.status().ToString());
  const PackedDrive drive = PackDrive(*std::move(route), simulation, options.frames);
  const double frame_bytes = MeanFrameBytes(drive.frames);
  std::printf(
      "route %s, policy %d, %zu frames of %.1f kB at %.0f frames/s (0: unpaced), "
      "medians of %zu rounds\n",
      options.route.c_str(),
      options.policy,
      drive.frames.size(),
      1e-3 * frame_bytes,
      options.rate_hz,
      options.rounds);
  PrintHeader();
  std::vector<Figures> all_without;
  for (const std::string& text : options.cases) {
    std::vector<Figures> without;
    std::vector<Figures> with;
    without.reserve(options.rounds);
    with.reserve(options.rounds);
    for (std::size_t round = 0; round < options.rounds; ++round) {
      without.push_back(RunOnce(options, {}, drive.frames));
      with.push_back(RunOnce(options, ParseCase(text), drive.frames));
    }
    PrintCase(text, without, with, frame_bytes);
    all_without.insert(all_without.end(), without.begin(), without.end());
  }
  PrintCase("none", all_without, all_without, frame_bytes);
}

}  // namespace
}  // namespace steadymap::benchmarks

int main(int count, char** arguments) {
  using steadymap::benchmarks::Options;
  Options options;
  CLI::App app("Measures the effect of watchers on the upload, and the content they receive");
  app.add_option("--case", options.cases, "COUNT[:FILTER[:STALLED]], any number of them");
  app.add_option("--route", options.route, "Route of the simulator");
  app.add_option("--policy", options.policy, "Number of the policy: 1 static, 5 pocd");
  app.add_option("--rate", options.rate_hz, "Frames per second; 0: as fast as possible");
  app.add_option("--frames", options.frames, "Maximum number of frames; 0: all");
  app.add_option("--rounds", options.rounds, "Runs of each case");
  app.add_option("--connections", options.connections, "Maximum number of connections");
  CLI11_PARSE(app, count, arguments);
  try {
    steadymap::benchmarks::Run(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "watch_benchmark: %s\n", error.what());
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}
