// Measures the deltas that a watcher of everything receives while a robot drives through the same
// place repeatedly, compared with the robot's upload, and the composition of those deltas:
//
//   build/release/tests/benchmark/delta_benchmark
//   build/release/tests/benchmark/delta_benchmark --drives 4 --rate 10 --sensor steady
//
// The first drive maps the place; later ones observe no changes. Sensors: full (all noise and pose
// drift), steady (no drift), ideal. Voxels are classified by their change since their leaf was last
// sent; young ones have a weight below 2; calm leaves have at most 5 % changed voxels. "if whole"
// is the share of the upload if leaves were sent with their unchanged voxels.

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "client/bench/simulator/routes/named_routes.h"
#include "client/map/map_client.h"
#include "client/transport/channel.h"
#include "tests/benchmark/delta_account.h"
#include "tests/benchmark/frame_feed.h"
#include "tests/benchmark/watch_crowd.h"
#include "tests/support/daemon_process.h"
#include "tests/support/temporary_folder.h"

namespace steadymap::benchmarks {
namespace {

constexpr std::chrono::seconds kCatchUpLimit{60};

struct Options {
  std::string place = "baseline";
  std::string sensor = "full";
  std::size_t drives = 4;
  int policy = v1::UPDATE_POLICY_POCD;
  double rate_hz = 30.0;
};

SensorModel MakeSensor(const std::string& name) {
  if (name == "full") return SensorModel::Full();
  if (name == "steady") return SensorModel();
  if (name == "ideal") return SensorModel::Ideal();
  throw std::runtime_error("unknown sensor \"" + name + "\"");
}

/// Repeats the route's last sequence `drives` times, with different noise each time.
PackedDrive PackDrives(const Options& options) {
  auto route = MakeRoute(options.place);
  if (!route.ok()) throw std::runtime_error(route.status().ToString());
  const RouteSequence sequence = route->sequences.back();
  route->sequences.assign(options.drives, sequence);
  SimulationOptions simulation;
  simulation.sensor = MakeSensor(options.sensor);
  return PackDrive(*std::move(route), simulation, 0);
}

/// Returns for each drive the content of the steps with the last frame in that drive.
std::vector<DeltaAccount> AccountByDrive(const PackedDrive& drive,
                                         const std::vector<v1::WatchMapResponse>& messages) {
  std::vector<DeltaAccount> accounts(drive.sequence_of.back() + 1);
  DeltaBookkeeper bookkeeper(VoxelScale{});
  for (const v1::WatchMapResponse& message : messages) {
    const std::uint64_t revision = message.has_delta()    ? message.delta().revision()
                                   : message.has_events() ? message.events().revision()
                                                          : message.progress().revision();
    // The map was empty.
    if (revision == 0) continue;
    bookkeeper.Book(message, &accounts.at(drive.sequence_of.at(revision - 1)));
  }
  return accounts;
}

void PrintDrive(std::size_t number,
                const DeltaAccount& account,
                double frames,
                double uploaded_bytes) {
  const auto percent = [](double part, double whole) {
    return whole > 0.0 ? 100.0 * part / whole : 0.0;
  };
  const double moved = account.moved_voxels;
  const double leaf_bytes = account.background_bytes + account.object_leaf_bytes;
  std::printf(
      "%5zu %9.1f %9.2f %7.2f %7.2f | %6.1f %6.1f %6.1f %6.1f | %7.1f %5.1f %6.1f %6.1f %6.1f "
      "%6.1f %6.1f %6.2f %7.1f\n",
      number,
      1e-3 * uploaded_bytes / frames,
      1e-3 * account.bytes() / frames,
      percent(account.bytes(), uploaded_bytes),
      percent(account.bytes() - leaf_bytes + account.whole_bytes, uploaded_bytes),
      percent(account.background_bytes, account.bytes()),
      percent(account.object_leaf_bytes, account.bytes()),
      percent(account.object_state_bytes, account.bytes()),
      percent(account.event_bytes + account.other_bytes, account.bytes()),
      account.leaves / frames,
      percent(account.patches, account.leaves),
      percent(account.calm_leaves, account.leaves),
      percent(account.new_voxels, account.voxels),
      percent(account.weighed_voxels, account.voxels),
      percent(moved, account.voxels),
      percent(account.young_voxels, moved),
      moved > 0.0 ? 1e3 * account.moved_m / moved : 0.0,
      account.moved_objects / frames);
}

void Run(const Options& options) {
  const PackedDrive drive = PackDrives(options);
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
  WatcherPlan plan;
  plan.keeps = true;
  plan.request.set_map(map.ToString());
  plan.request.set_start(v1::WATCH_START_SNAPSHOT_THEN_FOLLOW);
  plan.request.set_takes_patches(true);
  WatchCrowd crowd(daemon.address(), 1, {plan});
  const FeedRecord feed = FeedFrames(daemon.address(), map, drive.frames, options.rate_hz);
  if (!crowd.AwaitRevision(drive.frames.size(), kCatchUpLimit)) {
    throw std::runtime_error("the watcher did not catch up");
  }
  const std::vector<WatcherRecord> records = crowd.Finish();
  const std::vector<DeltaAccount> accounts = AccountByDrive(drive, records[0].messages);
  std::printf("%s, sensor %s, policy %d, %.1f frames/s, %zu steps\n",
              options.place.c_str(),
              options.sensor.c_str(),
              options.policy,
              feed.frames_per_second(),
              records[0].steps.size());
  std::printf(
      "drive  uploaded   a delta    %% of     if | %% of the delta's bytes       | leaves a %% of "
      "them   %% of their voxels          moved objects\n"
      "      kB/frame  kB/frame  upload   whole | ground object states  other |   frame patch   "
      "calm    new weight  moved  young    mm /frame\n");
  for (std::size_t i = 0; i < accounts.size(); ++i) {
    double frames = 0.0;
    double bytes = 0.0;
    for (std::size_t k = 0; k < drive.frames.size(); ++k) {
      if (drive.sequence_of[k] != i) continue;
      frames += 1.0;
      bytes += static_cast<double>(drive.frames[k].ByteSizeLong());
    }
    PrintDrive(i + 1, accounts[i], frames, bytes);
  }
}

}  // namespace
}  // namespace steadymap::benchmarks

int main(int count, char** arguments) {
  using steadymap::benchmarks::Options;
  Options options;
  CLI::App app("Measures the deltas of a watcher while a robot drives through a place repeatedly");
  app.add_option("--place", options.place, "Route; only its last sequence is used");
  app.add_option("--sensor", options.sensor, "full, steady or ideal");
  app.add_option("--drives", options.drives, "Number of drives")->check(CLI::PositiveNumber);
  app.add_option("--policy", options.policy, "Number of the policy: 1 static, 5 pocd");
  app.add_option("--rate", options.rate_hz, "Frames per second; 0: as fast as possible");
  CLI11_PARSE(app, count, arguments);
  try {
    steadymap::benchmarks::Run(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "delta_benchmark: %s\n", error.what());
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}
