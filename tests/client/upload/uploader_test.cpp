#include "client/upload/uploader.h"

#include <algorithm>
#include <future>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "core/types/error.h"
#include "proto/convert_status.h"
#include "tests/client/upload/upload_harness.h"

namespace steadymap {
namespace {

TEST(FrameUploader, SendsEveryFrameOnceInOrderAndWaitsForIntegration) {
  std::vector<std::uint64_t> received;
  v1::UploadOpen open;
  UploadHarness harness({[&](ScriptedStream& stream) {
    open = stream.ReadOpen();
    stream.SendOpened(0, 64);
    grpc::Status status = stream.AcceptRest();
    received = stream.received();
    return status;
  }});
  const absl::StatusOr<UploadSummary> summary = harness.Upload(50);
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(received, Sequences(1, 50));
  EXPECT_EQ(open.map(), "tenants/default/maps/kitchen");
  EXPECT_EQ(open.robot(), "robot-7");
  EXPECT_EQ(open.sensor(), "left");
  EXPECT_EQ(open.session(), "session-1");
  EXPECT_EQ(open.last_durable_client_seq(), 0U);
  EXPECT_EQ(summary->progress.pushed, 50U);
  EXPECT_EQ(summary->progress.sent, 50U);
  EXPECT_EQ(summary->progress.durable, 50U);
  EXPECT_EQ(summary->progress.integrated, 50U);
  EXPECT_EQ(summary->progress.refused, 0U);
  EXPECT_EQ(summary->progress.revision, 50U);
  EXPECT_EQ(summary->progress.reconnections, 0U);
}

TEST(FrameUploader, NothingPushedEndsWell) {
  UploadHarness harness({[](ScriptedStream& stream) {
    stream.ReadOpen();
    stream.SendOpened(0, 8);
    return stream.AcceptRest();
  }});
  const absl::StatusOr<UploadSummary> summary = harness.Upload(0);
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(summary->progress, UploadProgress());
}

TEST(FrameUploader, NeverSendsMoreThanItHasCreditFor) {
  // Credit for two frames, then credit in uneven amounts; ScriptedStream checks each batch.
  UploadHarness harness({[&](ScriptedStream& stream) {
    stream.ReadOpen();
    stream.SendOpened(0, 3, 2'500);
    EXPECT_TRUE(stream.ReadUntil(2));
    stream.SendCredit(40, 1'300);
    EXPECT_TRUE(stream.ReadUntil(3));
    stream.SendCredit(0, 100'000);
    return stream.AcceptRest();
  }});
  const absl::StatusOr<UploadSummary> summary = harness.Upload(20, 1'000);
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(summary->progress.integrated, 20U);
}

TEST(FrameUploader, SendsOnlyWhatIsNotDurableAfterTheStreamBreaks) {
  std::vector<std::uint64_t> first;
  std::vector<std::uint64_t> second;
  std::uint64_t last_durable = 0;
  UploadHarness harness({[&](ScriptedStream& stream) {
                           stream.ReadOpen();
                           stream.SendOpened(0, 10);
                           EXPECT_TRUE(stream.ReadUntil(10));
                           stream.SendAck(v1::ACK_LEVEL_DURABLE, 4);
                           first = stream.received();
                           return Failure(absl::StatusCode::kUnavailable);
                         },
                         [&](ScriptedStream& stream) {
                           last_durable = stream.ReadOpen().last_durable_client_seq();
                           // Frames 5 and 6 became durable, but the acknowledgement was lost.
                           stream.SendOpened(6, 100);
                           grpc::Status status = stream.AcceptRest();
                           second = stream.received();
                           return status;
                         }});
  const absl::StatusOr<UploadSummary> summary = harness.Upload(15);
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(first, Sequences(1, 10));
  EXPECT_EQ(second, Sequences(7, 15));
  EXPECT_EQ(last_durable, 4U);
  EXPECT_EQ(summary->progress.integrated, 15U);
  EXPECT_EQ(summary->progress.sent, 15U);
  EXPECT_EQ(summary->progress.sent_again, 4U);
  EXPECT_EQ(summary->progress.reconnections, 1U);
  EXPECT_EQ(harness.delays.size(), 1U);
}

TEST(FrameUploader, GoesOnWhereAnEarlierProcessOfTheSessionStopped) {
  std::vector<std::uint64_t> received;
  UploadHarness harness({[&](ScriptedStream& stream) {
    stream.ReadOpen();
    stream.SendOpened(12, 100);
    grpc::Status status = stream.AcceptRest();
    received = stream.received();
    return status;
  }});
  const absl::StatusOr<UploadSummary> summary = harness.Upload(20);
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(received, Sequences(13, 20));
  EXPECT_EQ(summary->progress.sent, 8U);
  EXPECT_EQ(summary->progress.integrated, 20U);
}

TEST(FrameUploader, ReportsEachRefusedFrameWithReasonAndField) {
  v1::RefusedFrame refused;
  refused.set_client_seq(3);
  *refused.mutable_status() =
      ToProto(InvalidField(reason::kNonFinitePose, "frames[2].pose", "it is NaN"));
  UploadHarness harness({[&](ScriptedStream& stream) {
    stream.ReadOpen();
    stream.SendOpened(0, 100);
    EXPECT_TRUE(stream.ReadUntil(5));
    stream.SendAck(v1::ACK_LEVEL_DURABLE, 5, {refused});
    // Repeated, which a server should not do.
    stream.SendAck(v1::ACK_LEVEL_INTEGRATED, 5, {refused});
    return grpc::Status::OK;
  }});
  const absl::StatusOr<UploadSummary> summary = harness.Upload(5);
  ASSERT_TRUE(summary.ok()) << summary.status();
  ASSERT_EQ(summary->refused.size(), 1U);
  EXPECT_EQ(summary->refused[0].client_seq, 3U);
  EXPECT_EQ(summary->refused[0].status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(ReasonOf(summary->refused[0].status), "NON_FINITE_POSE");
  EXPECT_EQ(FieldOf(summary->refused[0].status), "frames[2].pose");
  EXPECT_EQ(summary->progress.refused, 1U);
  EXPECT_EQ(summary->progress.durable, 4U);
  EXPECT_EQ(summary->progress.integrated, 4U);
}

TEST(FrameUploader, AFrameThatNoMessageCanHoldEndsTheUpload) {
  UploadHarness harness({[&](ScriptedStream& stream) {
    stream.ReadOpen();
    stream.SendOpened(0, 100, 1'000'000, 4'000);
    return stream.AcceptRest();
  }});
  const absl::StatusOr<UploadSummary> summary = harness.Upload(1, 4'000);
  EXPECT_EQ(summary.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(ReasonOf(summary.status()), reason::kMessageTooLarge);
  EXPECT_TRUE(harness.delays.empty());
}

TEST(FrameUploader, AnAcknowledgementOfAFrameNeverSentIsAnError) {
  UploadHarness harness({[&](ScriptedStream& stream) {
    stream.ReadOpen();
    stream.SendOpened(0, 100);
    stream.SendAck(v1::ACK_LEVEL_DURABLE, 1'000);
    v1::FrameBatch batch;
    while (stream.ReadBatch(&batch)) {
    }
    return grpc::Status::OK;
  }});
  EXPECT_EQ(harness.Upload(5).status().code(), absl::StatusCode::kInternal);
}

TEST(FrameUploader, KeepsFewFramesInMemory) {
  constexpr std::size_t kFrameBytes = 10'000;
  std::uint64_t acknowledged = 0;
  std::uint64_t most_ahead = 0;
  UploadHarness harness({[&](ScriptedStream& stream) {
    stream.ReadOpen();
    stream.SendOpened(0, 1'000'000);
    v1::FrameBatch batch;
    while (stream.ReadBatch(&batch)) {
      most_ahead = std::max(most_ahead, stream.received().back() - acknowledged);
      // Acknowledges two frames late, except the first and the last.
      if (stream.received().back() > 2) acknowledged = stream.received().back() - 2;
      stream.SendAck(v1::ACK_LEVEL_DURABLE, acknowledged);
    }
    stream.SendAck(v1::ACK_LEVEL_INTEGRATED, stream.received().back());
    return grpc::Status::OK;
  }});
  harness.options.max_buffered_bytes = 4 * kFrameBytes;
  const absl::StatusOr<UploadSummary> summary = harness.Upload(200, kFrameBytes);
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_LE(most_ahead, 5U);
}

TEST(FrameUploader, ReportsProgressThatNeverFalls) {
  std::vector<UploadProgress> reports;
  UploadHarness harness({[&](ScriptedStream& stream) {
    stream.ReadOpen();
    stream.SendOpened(0, 16);
    return stream.AcceptRest();
  }});
  harness.options.on_progress = [&](const UploadProgress& progress) {
    reports.push_back(progress);
  };
  ASSERT_TRUE(harness.Upload(40).ok());
  ASSERT_FALSE(reports.empty());
  for (std::size_t i = 1; i < reports.size(); ++i) {
    EXPECT_GE(reports[i].durable, reports[i - 1].durable);
    EXPECT_GE(reports[i].integrated, reports[i - 1].integrated);
  }
  EXPECT_EQ(reports.back().integrated, 40U);
}

TEST(FrameUploader, DestructionEndsAnUploadThatHangs) {
  std::promise<void> opened;
  UploadHarness harness({[&](ScriptedStream& stream) {
    stream.ReadOpen();
    stream.SendOpened(0, 0);  // Never any credit.
    opened.set_value();
    v1::FrameBatch batch;
    EXPECT_FALSE(stream.ReadBatch(&batch));
    return grpc::Status::OK;
  }});
  FrameUploader uploader(harness.server.channels(), kKitchen, harness.options);
  EXPECT_TRUE(uploader.Push(FrameOfBytes(10)).ok());
  opened.get_future().wait();
}

TEST(FrameUploader, PushAfterFinishIsRefused) {
  UploadHarness harness({[&](ScriptedStream& stream) {
    stream.ReadOpen();
    stream.SendOpened(0, 10);
    return stream.AcceptRest();
  }});
  FrameUploader uploader(harness.server.channels(), kKitchen, harness.options);
  ASSERT_TRUE(uploader.Finish().ok());
  EXPECT_EQ(uploader.Push(FrameOfBytes(1)).code(), absl::StatusCode::kFailedPrecondition);
}

// A source with an unreadable second frame.
class DamagedSource final : public FrameSource {
 public:
  std::size_t frame_count() const override { return 4; }

  absl::StatusOr<std::optional<v1::Frame>> Next() override {
    ++next_;
    if (next_ == 2) return absl::NotFoundError("0001.png is missing");
    if (next_ > 4) return std::nullopt;
    return FrameOfBytes(10);
  }

  absl::StatusOr<v1::Frame> Read(std::size_t index) override {
    return NoFrameAt(index, 0);  // These tests lose no frames.
  }

 private:
  int next_ = 0;
};

TEST(UploadAll, LeavesOutWhatTheSourceCannotRead) {
  std::vector<std::uint64_t> received;
  UploadHarness harness({[&](ScriptedStream& stream) {
    stream.ReadOpen();
    stream.SendOpened(0, 10);
    grpc::Status status = stream.AcceptRest();
    received = stream.received();
    return status;
  }});
  DamagedSource source;
  FrameUploader uploader(harness.server.channels(), kKitchen, harness.options);
  std::vector<std::size_t> unreadable;
  UploadAllCallbacks callbacks;
  callbacks.on_unreadable = [&unreadable](const UnreadableFrame& frame) {
    unreadable.push_back(frame.index);
  };
  const absl::StatusOr<UploadSummary> summary = UploadAll(&source, &uploader, callbacks);
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(unreadable, std::vector<std::size_t>{1});
  EXPECT_EQ(received, Sequences(1, 3));
}

}  // namespace
}  // namespace steadymap
