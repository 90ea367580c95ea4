// Tests uploads to a daemon whose store is replaced by an older copy meanwhile.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "client/bench/simulator/simulated_frame_source.h"
#include "client/map/map_client.h"
#include "client/transport/channel.h"
#include "client/upload/frame_replay.h"
#include "client/upload/uploader.h"
#include "tests/support/daemon_process.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

const MapName kRestored{"default", "hall"};

class RestoredUploadTest : public ::testing::Test {
 protected:
  RestoredUploadTest() : source_(SimulatedFrameSource::Open("twin", {.stride = 6}).value()) {}

  void SetUp() override { ASSERT_TRUE(Client().CreateMap(kRestored, {}).ok()); }

  MapClient Client() const { return MapClient(OpenChannel(daemon_.address())); }

  std::uint64_t frame_count() const { return source_->frame_count(); }

  static void Replace(const std::filesystem::path& from, const std::filesystem::path& to) {
    std::filesystem::remove_all(to);
    std::filesystem::copy(from, to, std::filesystem::copy_options::recursive);
  }

  /// Copies the store when a third of the frames is durable, and restores the copy when two thirds
  /// are.
  UploaderOptions Options() {
    UploaderOptions options;
    options.session = "s-1";
    options.max_buffered_bytes = 1;  // One frame at a time.
    options.on_progress = [this](const UploadProgress& progress) {
      const bool copies = stops_ == 0 && progress.durable >= frame_count() / 3;
      const bool replaces = stops_ == 1 && progress.durable >= frame_count() * 2 / 3;
      if (!copies && !replaces) return;
      ++stops_;
      daemon_.Kill();
      copies ? Replace(data_, copy_) : Replace(copy_, data_);
      daemon_.Restart();
    };
    options.on_lost = [this](const LostFrames& lost) { lost_.push_back(lost); };
    return options;
  }

  std::string Surface(const MapName& name) const {
    std::string file;
    const auto exported =
        Client().ExportMap(name, v1::EXPORT_FORMAT_PLY, {}, [&file](std::string_view chunk) {
          file += chunk;
          return absl::OkStatus();
        });
    EXPECT_TRUE(exported.ok()) << exported.status();
    return file;
  }

  TemporaryFolder folder_;
  const std::filesystem::path data_ = folder_.path() / "data";
  const std::filesystem::path copy_ = folder_.path() / "copy";
  DaemonProcess daemon_{folder_.path()};
  std::unique_ptr<SimulatedFrameSource> source_;
  int stops_ = 0;
  std::vector<LostFrames> lost_;
};

TEST_F(RestoredUploadTest, ARecordingIsSentAgainAndTheMapIsAsIfNothingHadHappened) {
  FrameReplay frames(source_.get());
  UploaderOptions options = Options();
  options.read_again = [&frames](std::uint64_t client_seq) {
    return frames.ReadPushed(client_seq);
  };
  absl::StatusOr<UploadSummary> summary;
  {
    FrameUploader uploader(ChannelsTo(daemon_.address()), kRestored, options);
    summary = UploadAll(&frames, &uploader);
  }
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(stops_, 2);
  ASSERT_EQ(lost_.size(), 1U);
  EXPECT_GE(lost_[0].last, frame_count() * 2 / 3);
  EXPECT_EQ(summary->progress.integrated, frame_count());
  EXPECT_EQ(summary->progress.lost, 0U);
  EXPECT_EQ(Client().GetMap(kRestored)->state().integrated_map_seq(), frame_count());

  const MapName undisturbed{"default", "undisturbed"};
  ASSERT_TRUE(Client().CreateMap(undisturbed, {}).ok());
  const auto again = SimulatedFrameSource::Open("twin", {.stride = 6});
  FrameUploader uploader(ChannelsTo(daemon_.address()), undisturbed, {});
  ASSERT_TRUE(UploadAll(again->get(), &uploader).ok());
  EXPECT_EQ(Surface(kRestored), Surface(undisturbed));
}

TEST_F(RestoredUploadTest, ALiveStreamSaysWhatIsLostAndGoesOnBehindIt) {
  FrameUploader uploader(ChannelsTo(daemon_.address()), kRestored, Options());
  const absl::StatusOr<UploadSummary> summary = UploadAll(source_.get(), &uploader);
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(stops_, 2);
  ASSERT_EQ(lost_.size(), 1U);
  EXPECT_EQ(summary->lost, lost_);
  const std::uint64_t lost = lost_[0].last + 1 - lost_[0].first;
  EXPECT_EQ(summary->progress.lost, lost);
  EXPECT_EQ(summary->progress.integrated, frame_count() - lost);
  EXPECT_EQ(Client().GetMap(kRestored)->state().integrated_map_seq(), frame_count() - lost);
}

TEST_F(RestoredUploadTest, WhoSaysNothingOfLossesHearsOfThem) {
  UploaderOptions options = Options();
  options.on_lost = nullptr;
  FrameUploader uploader(ChannelsTo(daemon_.address()), kRestored, options);
  EXPECT_EQ(UploadAll(source_.get(), &uploader).status().code(), absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace steadymap
