// Tests clients whose daemon is killed and restarted: the first attempt after the restart succeeds.
// The delays between attempts are tested in tests/client/transport/backoff_test.cpp.

#include <atomic>
#include <chrono>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include <absl/synchronization/notification.h>
#include <absl/time/time.h>
#include <gtest/gtest.h>

#include "client/cli/command_line.h"
#include "client/map/map_client.h"
#include "client/map/map_mirror.h"
#include "client/transport/channel.h"
#include "client/upload/uploader.h"
#include "tests/support/daemon_process.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/wall_frame.h"

namespace steadymap {
namespace {

using std::chrono::milliseconds;

const MapName kYard{"default", "yard"};

/// Number of failed attempts of a client before the restart of the daemon.
constexpr int kTriesInVain = 3;

constexpr absl::Duration kHang = absl::Seconds(60);

class ReturnTest : public ::testing::Test {
 protected:
  ReturnTest() { EXPECT_TRUE(MapClient(OpenChannel(daemon_.address())).CreateMap(kYard, {}).ok()); }

  /// Replaces the waits of a client: after `kTriesInVain` failed attempts, the daemon is restarted.
  std::function<void(milliseconds)> RestartInTheEnd() {
    return [this](milliseconds) {
      killed_.WaitForNotification();
      if (++waits_ == kTriesInVain) daemon_.Restart();
    };
  }

  void Kill() {
    daemon_.Kill();
    killed_.Notify();
  }

  TemporaryFolder folder_;
  DaemonProcess daemon_{folder_.path()};
  absl::Notification killed_;
  std::atomic<int> waits_ = 0;
};

TEST_F(ReturnTest, AnUploadGoesOnWithTheFirstTryThatFindsTheDaemon) {
  UploaderOptions options;
  options.sleep = RestartInTheEnd();
  absl::Notification durable;
  options.on_progress = [&](const UploadProgress& progress) {
    if (progress.durable == 1 && !durable.HasBeenNotified()) durable.Notify();
  };
  FrameUploader uploader(ChannelsTo(daemon_.address()), kYard, options);
  ASSERT_TRUE(uploader.Push(MakeWallFrame()).ok());
  ASSERT_TRUE(durable.WaitForNotificationWithTimeout(kHang));
  Kill();
  ASSERT_TRUE(uploader.Push(MakeWallFrame()).ok());
  const absl::StatusOr<UploadSummary> summary = uploader.Finish();
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(summary->progress.integrated, 2U);
  EXPECT_EQ(summary->progress.reconnections, static_cast<std::uint64_t>(kTriesInVain));
  EXPECT_EQ(waits_, kTriesInVain);
}

TEST_F(ReturnTest, AMirrorGoesOnWithTheFirstTryThatFindsTheDaemon) {
  MirrorOptions options;
  options.sleep = RestartInTheEnd();
  absl::Notification connected;
  absl::Notification returned;
  MirrorCallbacks callbacks;
  callbacks.on_state = [&](const WatchStateChange& change) {
    if (change.state != WatchState::kConnected) return;
    (connected.HasBeenNotified() ? returned : connected).Notify();
  };
  const auto mirror = MapMirror::Start(ChannelsTo(daemon_.address()), kYard, options, callbacks);
  ASSERT_TRUE(connected.WaitForNotificationWithTimeout(kHang));
  Kill();
  ASSERT_TRUE(returned.WaitForNotificationWithTimeout(kHang));
  EXPECT_EQ(waits_, kTriesInVain);
}

/// The command line against a daemon that starts only after some failed attempts.
class CommandBeforeItsDaemon : public ReturnTest {
 protected:
  CommandBeforeItsDaemon() { daemon_.Kill(); }

  int Run(const std::vector<std::string>& arguments) {
    CommandContext context{.out = out_, .err = err_, .server = daemon_.address()};
    context.open_channel = [this](const std::string& server) {
      if (++channels_ == kTriesInVain + 1) daemon_.Restart();
      return OpenChannel(server);
    };
    return RunCommandLine(arguments, &context);
  }

  std::string MirrorFolder() const { return (folder_.path() / "mirror").string(); }

  std::ostringstream out_;
  std::ostringstream err_;
  int channels_ = 0;
};

TEST_F(CommandBeforeItsDaemon, UploadsOnceItIsThere) {
  EXPECT_EQ(Run({"simulate", "yard", "--route", "twin", "--stride", "30", "--retry-for", "30"}), 0)
      << err_.str();
  EXPECT_NE(err_.str().find("waiting for the server"), std::string::npos) << err_.str();
}

TEST_F(CommandBeforeItsDaemon, MirrorsOnceItIsThere) {
  EXPECT_EQ(Run({"mirror", "yard", "--output", MirrorFolder(), "--once", "--retry-for", "30"}), 0)
      << err_.str();
}

TEST_F(CommandBeforeItsDaemon, WatchesOnceItIsThere) {
  EXPECT_EQ(Run({"watch", "yard", "--from", "snapshot", "--count", "1", "--retry-for", "30"}), 0)
      << err_.str();
}

TEST_F(CommandBeforeItsDaemon, TriesOnceWhereItIsToldSo) {
  EXPECT_EQ(Run({"mirror", "yard", "--output", MirrorFolder(), "--once", "--retry-for", "0"}), 1);
  EXPECT_EQ(channels_, 1);
}

}  // namespace
}  // namespace steadymap
