// Measures the time from the restart of a killed daemon to the reconnection of its C++ clients:
//
//   build/release/tests/benchmark/return_benchmark --rounds 20 --away 0.25
//
// An upload of ten frames per second, a watch and a mirror lose their daemon to kill -9,
// repeatedly. Time counts from the moment the new daemon listens: for the upload to its next
// acknowledgement, for the others to their next stream. `python_return_benchmark.py` measures the
// Python clients in the same way.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>
#include <absl/synchronization/mutex.h>
#include <absl/synchronization/notification.h>
#include <absl/time/time.h>

#include "client/map/map_client.h"
#include "client/map/map_mirror.h"
#include "client/transport/channel.h"
#include "client/upload/uploader.h"
#include "tests/support/daemon_process.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/wall_frame.h"

namespace steadymap {
namespace {

using Clock = std::chrono::steady_clock;

const MapName kHall{"default", "hall"};

constexpr absl::Duration kWait = absl::Seconds(60);
constexpr std::chrono::milliseconds kFramePeriod{100};

/// Reconnection of a client and its duration in each round.
class Return {
 public:
  void Expect() {
    const absl::MutexLock lock(&mutex_);
    is_back_ = false;
  }

  void Note() {
    const absl::MutexLock lock(&mutex_);
    if (is_back_) return;
    is_back_ = true;
    moment_ = Clock::now();
  }

  void Await(Clock::time_point served) {
    const absl::MutexLock lock(&mutex_);
    if (!mutex_.AwaitWithTimeout(absl::Condition(&is_back_), kWait)) {
      throw std::runtime_error("a client did not reconnect within a minute");
    }
    seconds_.push_back(std::max(0.0, std::chrono::duration<double>(moment_ - served).count()));
  }

  void Print(const char* name) {
    const absl::MutexLock lock(&mutex_);
    std::sort(seconds_.begin(), seconds_.end());
    std::printf(
        "%s: median %.3f s, most %.3f s\n", name, seconds_[seconds_.size() / 2], seconds_.back());
  }

 private:
  absl::Mutex mutex_;
  bool is_back_ = false;
  Clock::time_point moment_;
  std::vector<double> seconds_;
};

/// Ignores all content and records the start of streams.
class NotingConsumer final : public WatchConsumer {
 public:
  explicit NotingConsumer(Return* back) : back_(back) {}

  absl::Status Begin(const v1::WatchCreated&, WatchOpening) override { return absl::OkStatus(); }

  absl::Status Resync(const v1::WatchResync&) override { return absl::OkStatus(); }

  absl::Status TakeSnapshot(const v1::SnapshotChunk&) override { return absl::OkStatus(); }

  absl::Status TakeDelta(const v1::DeltaFragment&) override { return absl::OkStatus(); }

  absl::Status TakeEvents(const v1::EventBatch&) override { return absl::OkStatus(); }

  void Commit(const WatchStep&) override {}

  void Discard() override {}

  void OnState(const WatchStateChange& change) override {
    if (change.state == WatchState::kConnected) back_->Note();
  }

 private:
  Return* const back_;
};

void Measure(int rounds, double away_s) {
  const TemporaryFolder folder;
  DaemonProcess daemon(folder.path());
  if (!MapClient(OpenChannel(daemon.address())).CreateMap(kHall, {}).ok()) {
    throw std::runtime_error("the map could not be created");
  }
  Return uploading;
  Return watching;
  Return mirroring;
  UploaderOptions upload;
  upload.on_progress = [&](const UploadProgress&) { uploading.Note(); };
  FrameUploader uploader(ChannelsTo(daemon.address()), kHall, upload);
  absl::Notification stop;
  std::thread feed([&] {
    WallFrame frame;
    while (!stop.WaitForNotificationWithTimeout(absl::FromChrono(kFramePeriod))) {
      frame.capture_time_s += 0.1;
      if (!uploader.Push(MakeWallFrame(frame)).ok()) return;
    }
  });
  NotingConsumer consumer(&watching);
  auto watch =
      std::make_unique<MapWatch>(ChannelsTo(daemon.address()), kHall, WatchOptions(), &consumer);
  MirrorCallbacks callbacks;
  callbacks.on_state = [&](const WatchStateChange& change) {
    if (change.state == WatchState::kConnected) mirroring.Note();
  };
  auto mirror = MapMirror::Start(ChannelsTo(daemon.address()), kHall, {}, callbacks);
  for (int round = 0; round < rounds; ++round) {
    daemon.Kill();
    std::this_thread::sleep_for(std::chrono::duration<double>(away_s));
    for (Return* back : {&uploading, &watching, &mirroring}) back->Expect();
    daemon.Restart();
    const Clock::time_point served = Clock::now();
    for (Return* back : {&uploading, &watching, &mirroring}) back->Await(served);
  }
  watch.reset();
  mirror.reset();
  stop.Notify();
  feed.join();
  uploading.Print("C++ upload");
  watching.Print("C++ watch");
  mirroring.Print("C++ mirror");
}

}  // namespace
}  // namespace steadymap

int main(int argc, char** argv) {
  int rounds = 20;
  double away_s = 0.25;
  CLI::App app("Measures the reconnection time of C++ clients after a restart of the daemon.");
  app.add_option("--rounds", rounds, "Number of kills")->check(CLI::Range(1, 1000));
  app.add_option("--away", away_s, "Seconds without a daemon")->check(CLI::Range(0.0, 60.0));
  CLI11_PARSE(app, argc, argv);
  try {
    steadymap::Measure(rounds, away_s);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}
