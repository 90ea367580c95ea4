#include <algorithm>
#include <condition_variable>
#include <cstdlib>
#include <iostream>
#include <mutex>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "client/bench/simulator/routes/named_routes.h"
#include "client/bench/simulator/simulated_frame_source.h"
#include "client/map/map_client.h"
#include "client/transport/channel.h"
#include "client/upload/uploader.h"
#include "tests/support/daemon_process.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

const MapName kHall{"default", "hall"};
constexpr int kDefaultKills = 25;
constexpr int kKillsPerUpload = 5;
constexpr double kServingLimitS = 5.0;

// Small enough that an upload takes one second, and enough frames for five distinct kills.
constexpr int kImageScale = 4;
constexpr std::size_t kFrameCount = 150;

// The frames, and the end of their session.
constexpr std::size_t kEntryCount = kFrameCount + 1;

// Frames in transit at once; fewer frames give more regular acknowledgements.
constexpr std::size_t kFramesAhead = 10;

// Maximum delay of the kill after an acknowledgement, so that it can hit every stage.
constexpr int kMaxKillDelayUs = 8'000;

int FromEnvironment(const char* name, int otherwise) {
  const char* const text = std::getenv(name);  // NOLINT(concurrency-mt-unsafe): before any thread.
  return text == nullptr ? otherwise : std::atoi(text);
}

std::vector<v1::Frame> HallFrames() {
  Route route = MakeRoute("baseline").value();
  PinholeCamera& camera = route.camera;
  camera.width_px /= kImageScale;
  camera.height_px /= kImageScale;
  for (double* length_px : {&camera.fx, &camera.fy, &camera.cx, &camera.cy}) {
    *length_px /= kImageScale;
  }
  SimulatedFrameSource source(std::move(route), {.stride = 2});
  std::vector<v1::Frame> frames;
  while (frames.size() < kFrameCount) frames.push_back(source.Next().value().value());
  return frames;
}

/// Complete visible content of a map.
struct MapFiles {
  std::string ply;
  std::string vdb;
  std::string objects;  ///< In every state.
  std::string events;
  friend bool operator==(const MapFiles&, const MapFiles&) = default;
};

template <typename Message>
std::string Join(const std::vector<Message>& messages) {
  std::string joined;
  for (const Message& message : messages) joined += message.SerializeAsString() + '\n';
  return joined;
}

MapFiles Export(MapClient* client) {
  MapFiles files;
  for (const auto& [format, file] : {std::pair{v1::EXPORT_FORMAT_PLY, &files.ply},
                                     std::pair{v1::EXPORT_FORMAT_VDB, &files.vdb}}) {
    const auto header = client->ExportMap(kHall, format, {}, [file = file](std::string_view chunk) {
      *file += chunk;
      return absl::OkStatus();
    });
    EXPECT_TRUE(header.ok()) << header.status();
  }
  const absl::StatusOr<MapList<v1::Object>> objects =
      client->ListObjects(kHall, {.with_archived_and_tentative = true});
  EXPECT_TRUE(objects.ok()) << objects.status();
  if (objects.ok()) files.objects = Join(objects->entries);
  const absl::StatusOr<MapList<v1::ObjectEvent>> events = client->ListEvents(kHall);
  EXPECT_TRUE(events.ok()) << events.status();
  if (events.ok()) files.events = Join(events->entries);
  return files;
}

/// Uploads frames on its own thread, and lets the test wait for its progress.
class BackgroundUpload {
 public:
  BackgroundUpload(const std::string& address, const std::vector<v1::Frame>& frames)
      : uploader_(ChannelsTo(address), kHall, Options(frames)) {
    thread_ = std::thread([this, &frames] { Run(frames); });
  }

  ~BackgroundUpload() { thread_.join(); }

  BackgroundUpload(const BackgroundUpload&) = delete;
  BackgroundUpload& operator=(const BackgroundUpload&) = delete;

  /// Waits until this many frames are durable or the upload is over.
  void AwaitDurable(std::uint64_t frames) {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [&] { return is_over_ || durable_ >= frames; });
  }

  std::uint64_t durable() const { return uploader_.progress().durable; }

  absl::StatusOr<UploadSummary> AwaitSummary() {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [&] { return is_over_; });
    return summary_;
  }

 private:
  UploaderOptions Options(const std::vector<v1::Frame>& frames) {
    UploaderOptions options;
    options.max_buffered_bytes = kFramesAhead * frames.front().ByteSizeLong();
    options.max_batch_frames = 3;
    options.on_progress = [this](const UploadProgress& progress) {
      const std::lock_guard<std::mutex> lock(mutex_);
      durable_ = progress.durable;
      changed_.notify_all();
    };
    return options;
  }

  void Run(const std::vector<v1::Frame>& frames) {
    absl::Status status;
    for (std::size_t i = 0; i < frames.size() && status.ok(); ++i)
      status = uploader_.Push(frames[i]);
    absl::StatusOr<UploadSummary> summary = uploader_.Finish();
    const std::lock_guard<std::mutex> lock(mutex_);
    summary_ = std::move(summary);
    is_over_ = true;
    changed_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t durable_ = 0;
  bool is_over_ = false;
  absl::StatusOr<UploadSummary> summary_ = absl::UnknownError("not over yet");
  FrameUploader uploader_;
  std::thread thread_;
};

/// A map with objects and their history besides volumes.
v1::MapConfig HallConfig() {
  v1::MapConfig config;
  config.set_policy(v1::UPDATE_POLICY_POCD);
  return config;
}

/// Returns the map of an upload without kills.
MapFiles MapUndisturbed(const std::vector<v1::Frame>& frames) {
  const TemporaryFolder folder;
  DaemonProcess daemon(folder.path());
  MapClient client(OpenChannel(daemon.address()));
  EXPECT_TRUE(client.CreateMap(kHall, HallConfig()).ok());
  BackgroundUpload upload(daemon.address(), frames);
  const absl::StatusOr<UploadSummary> summary = upload.AwaitSummary();
  EXPECT_TRUE(summary.ok()) << summary.status();
  MapFiles files = Export(&client);
  EXPECT_GT(files.ply.size(), 100'000U) << "too little surface to compare";
  EXPECT_GT(files.events.size(), 1'000U) << "too few events to compare";
  return files;
}

/// Kills and restarts the daemon, and checks that it kept the acknowledged frames.
void KillAndRestart(DaemonProcess* daemon, const BackgroundUpload& upload) {
  const std::uint64_t acknowledged = upload.durable();
  daemon->Kill();
  daemon->Restart();
  EXPECT_LT(daemon->AwaitServing().count(), kServingLimitS);
  MapClient client(OpenChannel(daemon->address()));
  const absl::StatusOr<v1::Map> map = client.GetMap(kHall);
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_GE(map->state().durable_map_seq(), acknowledged) << "durable frames were lost";
}

TEST(KillTest, DurableFramesAreIntegratedExactlyOnceWhateverIsKilled) {
  const int kills = FromEnvironment("STEADYMAP_KILL_ROUNDS", kDefaultKills);
  const int seed =
      FromEnvironment("STEADYMAP_KILL_SEED", static_cast<int>(std::random_device()() >> 1));
  std::cout << kills << " kills, STEADYMAP_KILL_SEED=" << seed << std::endl;
  std::mt19937 random(static_cast<std::mt19937::result_type>(seed));
  std::uniform_int_distribution<std::uint64_t> moment(0, kFrameCount);
  std::uniform_int_distribution<int> delay_us(0, kMaxKillDelayUs);

  const std::vector<v1::Frame> frames = HallFrames();
  const MapFiles undisturbed = MapUndisturbed(frames);
  std::uint64_t reconnections = 0;
  for (int kill = 0; kill < kills && !HasFailure();) {
    const TemporaryFolder folder;
    DaemonProcess daemon(folder.path());
    ASSERT_TRUE(MapClient(OpenChannel(daemon.address())).CreateMap(kHall, HallConfig()).ok());
    std::vector<std::uint64_t> moments(
        static_cast<std::size_t>(std::min(kKillsPerUpload, kills - kill)));
    for (std::uint64_t& durable : moments) durable = moment(random);
    std::sort(moments.begin(), moments.end());

    BackgroundUpload upload(daemon.address(), frames);
    for (const std::uint64_t durable : moments) {
      upload.AwaitDurable(durable);
      // Not a wait for a condition: it randomises the time of the kill.
      std::this_thread::sleep_for(std::chrono::microseconds(delay_us(random)));
      KillAndRestart(&daemon, upload);
      ++kill;
    }
    const absl::StatusOr<UploadSummary> summary = upload.AwaitSummary();
    ASSERT_TRUE(summary.ok()) << summary.status();
    EXPECT_EQ(summary->progress.refused, 0U);
    reconnections += summary->progress.reconnections;

    MapClient client(OpenChannel(daemon.address()));
    const absl::StatusOr<v1::Map> map = client.GetMap(kHall);
    ASSERT_TRUE(map.ok()) << map.status();
    EXPECT_EQ(map->state().revision(), kEntryCount) << "an entry was lost or counted twice";
    EXPECT_EQ(map->state().durable_map_seq(), kEntryCount);
    EXPECT_TRUE(Export(&client) == undisturbed) << "the map differs from an undisturbed run's";
  }
  EXPECT_GT(reconnections, 0U) << "no kill fell into an upload";
}

}  // namespace
}  // namespace steadymap
