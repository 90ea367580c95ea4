#include <string>

#include <gtest/gtest.h>

#include "proto/batch_checksum.h"
#include "tests/contract/test_service.h"
#include "tests/contract/upload_client.h"

namespace steadymap {
namespace {

using absl::StatusCode;

class UploadCallTest : public ::testing::TestWithParam<Transport> {
 protected:
  absl::StatusOr<v1::UploadAck> Upload(std::uint64_t first_client_seq,
                                       int count,
                                       v1::AckLevel wait_for) {
    return UploadByCall(&service_, session_, MakeBatch(first_client_seq, count), wait_for);
  }

  TestService service_{GetParam()};
  const std::string map_ = service_.CreateMap("hall");
  const UploadSession session_{map_};
};

INSTANTIATE_TEST_SUITE_P(Transports,
                         UploadCallTest,
                         ::testing::Values(Transport::kInProcess, Transport::kLoopback),
                         TransportName);

TEST_P(UploadCallTest, AnswersAtTheLevelThatWasAskedFor) {
  const absl::StatusOr<v1::UploadAck> received = Upload(1, 2, v1::ACK_LEVEL_RECEIVED);
  ASSERT_TRUE(received.ok()) << received.status();
  EXPECT_EQ(received->level(), v1::ACK_LEVEL_RECEIVED);
  EXPECT_EQ(received->map_seq(), 0U);
  const absl::StatusOr<v1::UploadAck> durable = Upload(3, 2, v1::ACK_LEVEL_DURABLE);
  ASSERT_TRUE(durable.ok()) << durable.status();
  EXPECT_EQ(durable->map_seq(), 4U);
  EXPECT_EQ(durable->revision(), 0U);
  const absl::StatusOr<v1::UploadAck> integrated = Upload(5, 2, v1::ACK_LEVEL_INTEGRATED);
  ASSERT_TRUE(integrated.ok()) << integrated.status();
  EXPECT_EQ(integrated->client_seq(), 6U);
  EXPECT_EQ(integrated->map_seq(), 6U);
  EXPECT_EQ(integrated->revision(), 6U);
}

TEST_P(UploadCallTest, UnspecifiedLevelMeansDurable) {
  EXPECT_EQ(Upload(1, 1, v1::ACK_LEVEL_UNSPECIFIED)->level(), v1::ACK_LEVEL_DURABLE);
}

TEST_P(UploadCallTest, UnknownLevelIsRefused) {
  EXPECT_THAT(Upload(1, 1, static_cast<v1::AckLevel>(9)).status(),
              IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "wait_for"));
}

TEST_P(UploadCallTest, BatchesInAnyOrderCountOnceEach) {
  ASSERT_TRUE(Upload(7, 3, v1::ACK_LEVEL_DURABLE).ok());
  ASSERT_TRUE(Upload(1, 3, v1::ACK_LEVEL_DURABLE).ok());
  ASSERT_TRUE(Upload(7, 3, v1::ACK_LEVEL_DURABLE).ok());
  ASSERT_TRUE(Upload(2, 5, v1::ACK_LEVEL_DURABLE).ok());
  EXPECT_EQ(service_.GetMap(map_)->state().durable_map_seq(), 9U);
  UploadClient client(&service_);
  EXPECT_EQ(client.Open(session_)->resume_client_seq(), 9U);
}

TEST_P(UploadCallTest, GapsKeepTheResumePointBehindThem) {
  ASSERT_TRUE(Upload(1, 2, v1::ACK_LEVEL_DURABLE).ok());
  ASSERT_TRUE(Upload(5, 2, v1::ACK_LEVEL_DURABLE).ok());
  UploadClient client(&service_);
  EXPECT_EQ(client.Open(session_)->resume_client_seq(), 2U);
}

TEST_P(UploadCallTest, RepeatedAfterARestartCountsOnceAndIsIntegrated) {
  ASSERT_TRUE(Upload(1, 4, v1::ACK_LEVEL_DURABLE).ok());
  service_.Restart();
  const absl::StatusOr<v1::UploadAck> ack = Upload(1, 4, v1::ACK_LEVEL_INTEGRATED);
  ASSERT_TRUE(ack.ok()) << ack.status();
  EXPECT_EQ(ack->map_seq(), 4U);
  EXPECT_EQ(ack->revision(), 4U);
  EXPECT_EQ(service_.GetMap(map_)->state().durable_map_seq(), 4U);
}

TEST_P(UploadCallTest, TooManyGapsAreRefused) {
  const v1::Frame frame = MakeWallFrame({.width_px = 8, .height_px = 8});
  v1::FrameBatch batch;
  *batch.add_frames() = frame;
  absl::Status status;
  std::uint64_t sent = 0;
  for (; status.ok() && sent <= SequenceSet::kMaxIntervals; ++sent) {
    batch.set_first_client_seq(2 + 2 * sent);
    // Waits for the map at intervals, so that its queue does not fill up on a busy machine.
    const v1::AckLevel wait_for =
        sent % 256 == 255 ? v1::ACK_LEVEL_INTEGRATED : v1::ACK_LEVEL_DURABLE;
    status = UploadByCall(&service_, session_, batch, wait_for).status();
  }
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(ReasonOf(status), "BAD_SEQUENCE");
  EXPECT_EQ(service_.GetMap(map_)->state().durable_map_seq(), SequenceSet::kMaxIntervals);
}

TEST_P(UploadCallTest, WrongChecksumIsRefused) {
  v1::FrameBatch batch = MakeBatch(1, 1);
  batch.set_images_crc32c(ImagesCrc32c(batch) ^ 1U);
  EXPECT_THAT(UploadByCall(&service_, session_, batch, v1::ACK_LEVEL_DURABLE).status(),
              IsError(StatusCode::kDataLoss, "CHECKSUM", "batch.images_crc32c"));
}

TEST_P(UploadCallTest, WrongNamesAndNumberingNameTheField) {
  const auto upload = [this](const UploadSession& session, const v1::FrameBatch& batch) {
    return UploadByCall(&service_, session, batch, v1::ACK_LEVEL_DURABLE).status();
  };
  const v1::FrameBatch batch = MakeBatch(1, 1);
  EXPECT_THAT(upload({"tenants/test/maps/none"}, batch),
              IsError(StatusCode::kNotFound, "NOT_FOUND", "map"));
  EXPECT_THAT(upload({map_, "-"}, batch),
              IsError(StatusCode::kInvalidArgument, "BAD_NAME", "robot"));
  EXPECT_THAT(upload({map_, "r", ""}, batch),
              IsError(StatusCode::kInvalidArgument, "BAD_NAME", "session"));
  EXPECT_THAT(upload(session_, MakeBatch(0, 1)),
              IsError(StatusCode::kInvalidArgument, "BAD_SEQUENCE", "batch.first_client_seq"));
  EXPECT_THAT(upload(session_, MakeBatch(1, 0)),
              IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "batch.frames"));
}

TEST_P(UploadCallTest, AMillionEmptyFramesAreRefused) {
  v1::FrameBatch batch;
  batch.set_first_client_seq(1);
  for (int i = 0; i < 1'000'000; ++i) batch.add_frames();
  EXPECT_THAT(UploadByCall(&service_, session_, batch, v1::ACK_LEVEL_DURABLE).status(),
              IsError(StatusCode::kResourceExhausted, "MESSAGE_TOO_LARGE", ""));
}

TEST_P(UploadCallTest, DrainingServerRefuses) {
  service_.server().Drain();
  EXPECT_THAT(Upload(1, 1, v1::ACK_LEVEL_DURABLE).status(),
              IsError(StatusCode::kUnavailable, "DRAINING", ""));
}

TEST_P(UploadCallTest, TooLargeMessageIsRefusedWithItsReason) {
  WallFrame wall;
  wall.width_px = 2048;
  wall.height_px = 2048;
  v1::FrameBatch batch;
  batch.set_first_client_seq(1);
  *batch.add_frames() = MakeWallFrame(wall);
  EXPECT_THAT(UploadByCall(&service_, session_, batch, v1::ACK_LEVEL_DURABLE).status(),
              IsError(StatusCode::kResourceExhausted, "MESSAGE_TOO_LARGE", ""));
}

}  // namespace
}  // namespace steadymap
