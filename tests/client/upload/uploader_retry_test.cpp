#include <vector>

#include <gtest/gtest.h>

#include "core/types/error.h"
#include "proto/convert_status.h"
#include "proto/grpc_status.h"
#include "tests/client/upload/upload_harness.h"

namespace steadymap {
namespace {

using std::chrono::milliseconds;

class TerminalFailure : public ::testing::TestWithParam<absl::Status> {};

TEST_P(TerminalFailure, EndsTheUploadWithoutARetry) {
  UploadHarness harness({[&](ScriptedStream& stream) {
    stream.ReadOpen();
    return ToGrpcStatus(GetParam());
  }});
  const absl::StatusOr<UploadSummary> summary = harness.Upload(3);
  EXPECT_EQ(summary.status(), GetParam());
  EXPECT_EQ(harness.service.streams_opened(), 1U);
  EXPECT_TRUE(harness.delays.empty());
}

INSTANTIATE_TEST_SUITE_P(
    FrameUploader,
    TerminalFailure,
    ::testing::Values(
        MakeError(absl::StatusCode::kNotFound, reason::kNotFound, "no such map"),
        MakeError(absl::StatusCode::kInvalidArgument, reason::kBadName, "bad robot", "robot"),
        MakeError(absl::StatusCode::kAborted, reason::kUploadSuperseded, "another session"),
        MakeError(absl::StatusCode::kResourceExhausted, reason::kMessageTooLarge, "too large"),
        absl::PermissionDeniedError("not yours"),
        absl::UnauthenticatedError("who are you")));

class PassingFailure : public ::testing::TestWithParam<absl::Status> {};

TEST_P(PassingFailure, IsRetried) {
  UploadHarness harness({[&](ScriptedStream& stream) {
                           stream.ReadOpen();
                           return ToGrpcStatus(GetParam());
                         },
                         [&](ScriptedStream& stream) {
                           stream.ReadOpen();
                           stream.SendOpened(0, 100);
                           return stream.AcceptRest();
                         }});
  const absl::StatusOr<UploadSummary> summary = harness.Upload(3);
  ASSERT_TRUE(summary.ok()) << summary.status();
  ASSERT_EQ(harness.delays.size(), 1U);
  EXPECT_GE(harness.delays[0], milliseconds(RetryDelayMsOf(FromProto(ToProto(GetParam())))))
      << "as requested by the server";
}

INSTANTIATE_TEST_SUITE_P(
    FrameUploader,
    PassingFailure,
    ::testing::Values(
        MakeError(absl::StatusCode::kUnavailable, reason::kDraining, "draining"),
        MakeError(absl::StatusCode::kUnavailable, reason::kStoreReadOnly, "read only"),
        MakeError(absl::StatusCode::kResourceExhausted, reason::kQueueFull, "credit overrun"),
        MakeError(absl::StatusCode::kResourceExhausted, reason::kDiskLow, "disk low"),
        MakeError(absl::StatusCode::kDataLoss, reason::kChecksum, "damaged on its way")));

TEST(FrameUploader, WaitsLongerEachTimeAndGivesUpInTheEnd) {
  std::vector<FakeIngestService::Script> scripts(
      20, [](ScriptedStream&) { return Failure(absl::StatusCode::kAborted); });
  UploadHarness harness(scripts);
  harness.options.backoff = {.first_delay = milliseconds(100),
                             .max_delay = milliseconds(800),
                             .factor = 2.0,
                             .jitter = 0.0,
                             .give_up_after = milliseconds(2'000)};
  const absl::StatusOr<UploadSummary> summary = harness.Upload(3);
  EXPECT_EQ(summary.status().code(), absl::StatusCode::kAborted);
  EXPECT_EQ(harness.delays,
            (std::vector<milliseconds>{milliseconds(100),
                                       milliseconds(200),
                                       milliseconds(400),
                                       milliseconds(800),
                                       milliseconds(800)}));
  EXPECT_EQ(harness.service.streams_opened(), 6U);
}

TEST(FrameUploader, LooksForALostServerTwiceASecond) {
  std::vector<FakeIngestService::Script> scripts(
      20, [](ScriptedStream&) { return Failure(absl::StatusCode::kUnavailable); });
  UploadHarness harness(scripts);
  harness.options.backoff.jitter = 0.0;
  harness.options.backoff.give_up_after = milliseconds(2'000);
  EXPECT_EQ(harness.Upload(3).status().code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(harness.delays,
            (std::vector<milliseconds>{milliseconds(100),
                                       milliseconds(200),
                                       milliseconds(400),
                                       milliseconds(500),
                                       milliseconds(500),
                                       milliseconds(500)}));
}

TEST(FrameUploader, ProgressStartsTheDelaysAnew) {
  // Each stream makes one more frame durable and breaks; without the reset, 30 retries would be too
  // many.
  std::vector<FakeIngestService::Script> scripts;
  for (std::uint64_t frame = 1; frame <= 30; ++frame) {
    scripts.emplace_back([frame](ScriptedStream& stream) {
      stream.ReadOpen();
      stream.SendOpened(frame - 1, 1);
      EXPECT_TRUE(stream.ReadUntil(frame));
      stream.SendAck(v1::ACK_LEVEL_DURABLE, frame);
      return Failure(absl::StatusCode::kUnavailable);
    });
  }
  scripts.emplace_back([](ScriptedStream& stream) {
    stream.ReadOpen();
    stream.SendOpened(30, 100);
    EXPECT_FALSE(stream.ReadUntil(1));
    stream.SendAck(v1::ACK_LEVEL_INTEGRATED, 30);
    return grpc::Status::OK;
  });
  UploadHarness harness(scripts);
  harness.options.backoff = {.first_delay = milliseconds(100),
                             .max_delay = milliseconds(400),
                             .factor = 2.0,
                             .jitter = 0.0,
                             .give_up_after = milliseconds(300)};
  const absl::StatusOr<UploadSummary> summary = harness.Upload(30);
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(summary->progress.sent_again, 0U);
  EXPECT_EQ(harness.delays, std::vector<milliseconds>(30, milliseconds(100)));
}

TEST(FrameUploader, AsksForTheStateWhenAnIntegrationWasNotAcknowledged) {
  UploadHarness harness({[&](ScriptedStream& stream) {
    stream.ReadOpen();
    stream.SendOpened(0, 100);
    EXPECT_FALSE(stream.ReadUntil(6));
    stream.SendAck(v1::ACK_LEVEL_DURABLE, 5);
    return grpc::Status::OK;
  }});
  harness.service.state.set_resume_client_seq(5);
  harness.service.state.set_integrated_client_seq(5);
  const absl::StatusOr<UploadSummary> summary = harness.Upload(5);
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(summary->progress.integrated, 5U);
  EXPECT_EQ(summary->progress.revision, 0U) << "the uploader may lack the permission to read";
}

TEST(FrameUploader, ASessionThatIsSentAgainNamesTheMapsRevision) {
  FakeIngestService ingest({[](ScriptedStream& stream) {
    stream.ReadOpen();
    stream.SendOpened(5, 100);
    return stream.AcceptRest();
  }});
  ingest.state.set_resume_client_seq(5);
  ingest.state.set_integrated_client_seq(5);
  FakeMapService maps;
  maps.maps[kKitchen.ToString()].mutable_state()->set_revision(17);
  FakeServer server(&ingest, &maps);
  FrameUploader uploader(server.channels(), kKitchen, {});
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(uploader.Push(FrameOfBytes(100)).ok());
  const absl::StatusOr<UploadSummary> summary = uploader.Finish();
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(summary->progress.sent, 0U);
  EXPECT_EQ(summary->progress.integrated, 5U);
  EXPECT_EQ(summary->progress.revision, 17U);
}

TEST(FrameUploader, AnEndBeforeEverythingWasIntegratedIsRetried) {
  UploadHarness harness({[&](ScriptedStream& stream) {
                           stream.ReadOpen();
                           stream.SendOpened(0, 100);
                           return grpc::Status::OK;  // No message was read.
                         },
                         [&](ScriptedStream& stream) {
                           stream.ReadOpen();
                           stream.SendOpened(0, 100);
                           return stream.AcceptRest();
                         }});
  const absl::StatusOr<UploadSummary> summary = harness.Upload(5);
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(summary->progress.integrated, 5U);
  EXPECT_EQ(harness.delays.size(), 1U);
}

TEST(FrameUploader, AServerThatForgotDurableFramesIsAnAlarm) {
  UploadHarness harness({[&](ScriptedStream& stream) {
                           stream.ReadOpen();
                           stream.SendOpened(0, 100);
                           EXPECT_TRUE(stream.ReadUntil(5));
                           stream.SendAck(v1::ACK_LEVEL_DURABLE, 5);
                           return Failure(absl::StatusCode::kUnavailable);
                         },
                         [&](ScriptedStream& stream) {
                           stream.ReadOpen();
                           stream.SendOpened(2, 100);
                           return stream.AcceptRest();
                         }});
  const absl::StatusOr<UploadSummary> summary = harness.Upload(5);
  EXPECT_EQ(summary.status().code(), absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace steadymap
