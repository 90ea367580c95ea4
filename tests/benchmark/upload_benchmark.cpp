// Measures frames per second from a client's upload to INTEGRATED, through gRPC on loopback into a
// daemon with its durable store; client and daemon share the machine:
//
//   taskset -c 0,1 build/release/tests/benchmark/upload_benchmark
//
// The argument is the number of the map's policy: 1 static, 5 pocd. The frames are 640 x 360, depth
// and labels as PNG, packed in advance. `daemon_MB` is the daemon's peak resident memory so far.

#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <absl/strings/str_cat.h>
#include <benchmark/benchmark.h>

#include "client/bench/simulator/routes/named_routes.h"
#include "client/bench/simulator/simulated_frame_source.h"
#include "client/map/map_client.h"
#include "client/transport/channel.h"
#include "client/upload/uploader.h"
#include "core/frame/image_codec.h"
#include "tests/support/daemon_process.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

/// Renders two loops through the TorWIC hall with all sensor noise, packed as PNG; boxes were
/// rotated in between.
std::vector<v1::Frame> PackFrames() {
  SimulationOptions options;
  options.sensor = SensorModel::Full();
  Simulation simulation(MakeRoute("1-5").value(), options);
  std::vector<v1::Frame> frames;
  for (std::size_t i = 0; i < simulation.frame_count(); ++i) {
    const Frame frame = simulation.Render(i);
    v1::Frame message = PackSimulatedFrame(frame);
    message.mutable_depth()->set_encoding(v1::DEPTH_ENCODING_PNG_UINT16);
    message.mutable_depth()->set_data(EncodePixels(frame.depth.units, PixelEncoding::kPng));
    message.mutable_labels()->set_encoding(v1::LABEL_ENCODING_PNG);
    message.mutable_labels()->set_data(EncodePixels(frame.labels, PixelEncoding::kPng));
    frames.push_back(std::move(message));
  }
  return frames;
}

double PeakMemoryMb(pid_t process) {
  std::ifstream status(absl::StrCat("/proc/", process, "/status"));
  for (std::string line; std::getline(status, line);) {
    if (line.rfind("VmHWM:", 0) == 0) return std::strtod(line.c_str() + 6, nullptr) * 1024e-6;
  }
  return 0.0;
}

void Check(const absl::Status& status) {
  if (!status.ok()) throw std::runtime_error(status.ToString());
}

void UploadToIntegrated(benchmark::State& state) {
  static const std::vector<v1::Frame> frames = PackFrames();
  const TemporaryFolder folder;
  DaemonProcess daemon(folder.path());
  const auto channel = OpenChannel(daemon.address());
  std::size_t bytes = 0;
  for (const v1::Frame& frame : frames) bytes += frame.ByteSizeLong();
  v1::MapConfig config;
  config.set_policy(static_cast<v1::UpdatePolicy>(state.range(0)));
  int round = 0;
  while (state.KeepRunning()) {
    state.PauseTiming();
    const MapName map{"default", absl::StrCat("round-", ++round)};
    Check(MapClient(channel).CreateMap(map, config).status());
    std::vector<v1::Frame> copies = frames;
    FrameUploader uploader(ChannelsTo(daemon.address()), map, {});
    state.ResumeTiming();
    for (v1::Frame& frame : copies) Check(uploader.Push(std::move(frame)));
    const absl::StatusOr<UploadSummary> summary = uploader.Finish();
    Check(summary.status());
    if (!summary->refused.empty()) throw std::runtime_error("frames were refused");
  }
  const auto count = static_cast<double>(frames.size());
  state.counters["frames"] =
      benchmark::Counter(count, benchmark::Counter::kIsIterationInvariantRate);
  state.counters["kB_a_frame"] = static_cast<double>(bytes) / count * 1e-3;
  state.counters["daemon_MB"] = PeakMemoryMb(daemon.process());
}

BENCHMARK(UploadToIntegrated)
    ->ArgName("policy")
    ->Arg(v1::UPDATE_POLICY_STATIC)
    ->Arg(v1::UPDATE_POLICY_POCD)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond)
    ->MinTime(10.0);

}  // namespace
}  // namespace steadymap
