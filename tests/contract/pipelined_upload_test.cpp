// Tests streams that do not wait for acknowledgements while the store refuses some of their frames:
// every frame acknowledged as durable is in the log exactly once and in order.

#include <algorithm>
#include <cstdint>
#include <future>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/contract/test_service.h"
#include "tests/contract/upload_client.h"

namespace steadymap {
namespace {

class PipelinedUpload : public ::testing::Test {
 protected:
  /// Returns the capture times of the frames in the log, seconds, in order: `MakeBatch` gives frame
  /// n the time 100 + n.
  std::vector<std::int64_t> LoggedFrames() {
    const MapKey key = service_.store().ListMaps()->front().key;
    std::vector<std::int64_t> frames;
    const absl::Status status =
        service_.store().ReadLog(key, MapSequence(1), [&frames](const LogEntry& entry) {
          v1::Frame frame;
          EXPECT_TRUE(frame.ParseFromString(entry.packed_frame));
          frames.push_back(frame.capture_time().seconds() - 100);
          return absl::OkStatus();
        });
    EXPECT_TRUE(status.ok()) << status;
    return frames;
  }

  /// Sends all batches after the resume point without waiting; returns the last client sequence
  /// acknowledged as durable before the end of the stream.
  std::uint64_t SendWithoutWaiting(std::uint64_t last_frame, int batch_frames) {
    UploadClient client(&service_);
    const absl::StatusOr<v1::UploadOpened> opened = client.Open(session_, {v1::ACK_LEVEL_DURABLE});
    if (!opened.ok()) return 0;
    std::uint64_t next = opened->resume_client_seq() + 1;
    const std::uint64_t window_end =
        std::min(last_frame, opened->resume_client_seq() + opened->credit().frames());
    while (next <= window_end && client.Send(MakeBatch(next, batch_frames))) {
      next += static_cast<std::uint64_t>(batch_frames);
    }
    client.Close().IgnoreError();
    return std::max(opened->resume_client_seq(), client.newest(v1::ACK_LEVEL_DURABLE).client_seq());
  }

  TestService service_{Transport::kLoopback};
  const std::string map_ = service_.CreateMap("hall");
  const UploadSession session_{map_};
};

TEST_F(PipelinedUpload, BatchBehindARefusedOneIsRefusedToo) {
  std::promise<void> release;
  std::shared_future<void> released = release.get_future().share();
  service_.store().SetWriteHook([released] { released.wait(); });
  service_.store().SetDiskLowFor([appends = 0]() mutable { return ++appends == 1; });
  UploadClient client(&service_);
  ASSERT_TRUE(client.Open(session_, {v1::ACK_LEVEL_RECEIVED, v1::ACK_LEVEL_DURABLE}).ok());
  ASSERT_TRUE(client.Send(MakeBatch(1, 2)));
  ASSERT_TRUE(client.ReadUntil(v1::ACK_LEVEL_RECEIVED, 2));
  // The second batch waits in the queue while the log refuses the first.
  ASSERT_TRUE(client.Send(MakeBatch(3, 2)));
  ASSERT_TRUE(client.ReadUntil(v1::ACK_LEVEL_RECEIVED, 4));
  release.set_value();
  EXPECT_EQ(ReasonOf(client.Finish()), "DISK_LOW");
  UploadClient again(&service_);
  EXPECT_EQ(again.Open(session_)->resume_client_seq(), 0U);
  EXPECT_TRUE(LoggedFrames().empty());
  service_.store().SetWriteHook(nullptr);
}

TEST_F(PipelinedUpload, AcknowledgedFramesAreInTheLogOnceWhicheverAppendsAreRefused) {
  constexpr std::uint64_t kFrames = 120;
  for (std::uint32_t seed = 1; seed <= 10; ++seed) {
    service_.store().SetDiskLowFor(
        [random = std::mt19937(seed),
         refuses = std::bernoulli_distribution(0.02 * seed)]() mutable { return refuses(random); });
    const std::uint64_t first = LoggedFrames().size();
    std::uint64_t acknowledged = first;
    while (acknowledged < first + kFrames) {
      acknowledged = std::max(acknowledged, SendWithoutWaiting(first + kFrames, 3));
      const std::vector<std::int64_t> logged = LoggedFrames();
      ASSERT_GE(logged.size(), acknowledged) << "seed " << seed;
      for (std::size_t i = 0; i < logged.size(); ++i) {
        ASSERT_EQ(logged[i], static_cast<std::int64_t>(i + 1)) << "seed " << seed;
      }
    }
  }
  service_.store().SetDiskLowFor(nullptr);
}

}  // namespace
}  // namespace steadymap
