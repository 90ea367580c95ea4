#include <ctime>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "proto/batch_checksum.h"
#include "proto/convert_status.h"
#include "tests/contract/test_service.h"
#include "tests/contract/upload_client.h"
#include "tests/support/eventually.h"

namespace steadymap {
namespace {

using absl::StatusCode;

class UploadStreamTest : public ::testing::TestWithParam<Transport> {
 protected:
  TestService service_{GetParam()};
  const std::string map_ = service_.CreateMap("hall");
  const UploadSession session_{map_};
};

INSTANTIATE_TEST_SUITE_P(Transports,
                         UploadStreamTest,
                         ::testing::Values(Transport::kInProcess, Transport::kLoopback),
                         TransportName);

TEST_P(UploadStreamTest, OpeningAnswersResumePointCreditAndLimits) {
  UploadClient client(&service_);
  const absl::StatusOr<v1::UploadOpened> opened = client.Open(session_);
  ASSERT_TRUE(opened.ok()) << opened.status();
  EXPECT_EQ(opened->resume_client_seq(), 0U);
  EXPECT_EQ(opened->credit().frames(), LimitOptions().upload_window_frames);
  EXPECT_EQ(opened->credit().bytes(), LimitOptions().upload_window_bytes);
  EXPECT_EQ(opened->max_message_bytes(), LimitOptions().max_message_bytes);
  EXPECT_EQ(opened->max_image_side_px(), 4096U);
}

TEST_P(UploadStreamTest, HalfCloseIntegratesAcknowledgesAndEndsWithOk) {
  UploadClient client(&service_);
  ASSERT_TRUE(client.Open(session_).ok());
  ASSERT_TRUE(client.Send(MakeBatch(1, 3)));
  EXPECT_TRUE(client.Close().ok());
  EXPECT_EQ(client.newest(v1::ACK_LEVEL_DURABLE).client_seq(), 3U);
  const v1::UploadAck& ack = client.newest(v1::ACK_LEVEL_INTEGRATED);
  EXPECT_EQ(ack.client_seq(), 3U);
  EXPECT_EQ(ack.map_seq(), 3U);
  EXPECT_EQ(ack.revision(), 3U);
  EXPECT_EQ(service_.GetMap(map_)->state().revision(), 3U);
  EXPECT_GT(service_.GetMap(map_)->state().voxels(), 0U);
}

TEST_P(UploadStreamTest, HalfCloseWithoutFramesEndsWithOk) {
  UploadClient client(&service_);
  ASSERT_TRUE(client.Open(session_).ok());
  EXPECT_TRUE(client.Close().ok());
}

TEST_P(UploadStreamTest, AcknowledgesTheLevelsThatWereAskedFor) {
  UploadClient client(&service_);
  ASSERT_TRUE(client.Open(session_, {v1::ACK_LEVEL_RECEIVED}).ok());
  ASSERT_TRUE(client.Send(MakeBatch(1, 2)));
  EXPECT_TRUE(client.ReadUntil(v1::ACK_LEVEL_RECEIVED, 2));
  EXPECT_TRUE(client.Close().ok());
  EXPECT_EQ(client.newest(v1::ACK_LEVEL_DURABLE).client_seq(), 0U);
  EXPECT_EQ(client.newest(v1::ACK_LEVEL_INTEGRATED).client_seq(), 0U);
}

TEST_P(UploadStreamTest, BrokenFrameIsRefusedAloneWithItsFieldPath) {
  v1::FrameBatch batch = MakeBatch(1, 3);
  batch.mutable_frames(1)->mutable_depth()->mutable_data()->resize(10);
  UploadClient client(&service_);
  ASSERT_TRUE(client.Open(session_).ok());
  ASSERT_TRUE(client.Send(batch));
  EXPECT_TRUE(client.Close().ok());
  ASSERT_EQ(client.refused().size(), 1U);
  EXPECT_EQ(client.refused()[0].client_seq(), 2U);
  EXPECT_THAT(FromProto(client.refused()[0].status()),
              IsError(StatusCode::kInvalidArgument, "IMAGE_SIZE_MISMATCH", "frames[1].depth.data"));
  EXPECT_EQ(client.newest(v1::ACK_LEVEL_INTEGRATED).client_seq(), 3U);
  EXPECT_EQ(service_.GetMap(map_)->state().revision(), 2U);
  EXPECT_EQ(service_.GetMap(map_)->state().refused_frames(), 1U);
}

TEST_P(UploadStreamTest, BatchOfRefusedFramesIsAcknowledgedAndNotAskedForAgain) {
  v1::FrameBatch batch = MakeBatch(1, 2);
  for (v1::Frame& frame : *batch.mutable_frames()) frame.clear_capture_time();
  UploadClient client(&service_);
  ASSERT_TRUE(client.Open(session_).ok());
  ASSERT_TRUE(client.Send(batch));
  EXPECT_TRUE(client.Close().ok());
  EXPECT_EQ(client.refused().size(), 2U);
  UploadClient again(&service_);
  EXPECT_EQ(again.Open(session_)->resume_client_seq(), 2U);
}

TEST_P(UploadStreamTest, RightChecksumPasses) {
  v1::FrameBatch batch = MakeBatch(1, 2);
  batch.set_images_crc32c(ImagesCrc32c(batch));
  EXPECT_TRUE(UploadAndClose(&service_, session_, batch).ok());
}

TEST_P(UploadStreamTest, WrongChecksumTakesNothingOfTheBatch) {
  v1::FrameBatch batch = MakeBatch(1, 2);
  batch.set_images_crc32c(ImagesCrc32c(batch) + 1);
  EXPECT_THAT(UploadAndClose(&service_, session_, batch),
              IsError(StatusCode::kDataLoss, "CHECKSUM", "batch.images_crc32c"));
  EXPECT_EQ(service_.GetMap(map_)->state().durable_map_seq(), 0U);
}

TEST_P(UploadStreamTest, BatchBeforeOpenIsRefused) {
  UploadClient client(&service_);
  client.Send(MakeBatch(1, 1));
  EXPECT_THAT(client.Finish(), IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "batch"));
}

TEST_P(UploadStreamTest, EmptyMessageIsRefused) {
  UploadClient client(&service_);
  client.Send(v1::UploadFramesRequest());
  EXPECT_THAT(client.Finish(), IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "kind"));
}

TEST_P(UploadStreamTest, SecondOpenIsRefused) {
  UploadClient client(&service_);
  ASSERT_TRUE(client.Open(session_).ok());
  v1::UploadFramesRequest request;
  request.mutable_open()->set_map(map_);
  client.Send(request);
  EXPECT_THAT(client.Finish(), IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "open"));
}

TEST_P(UploadStreamTest, OpeningWithWrongNamesNamesTheField) {
  const auto open = [this](const UploadSession& session) {
    UploadClient client(&service_);
    return client.Open(session).status();
  };
  EXPECT_THAT(open({"tenants/test/maps/none"}),
              IsError(StatusCode::kNotFound, "NOT_FOUND", "open.map"));
  EXPECT_THAT(open({"hall"}), IsError(StatusCode::kInvalidArgument, "BAD_NAME", "open.map"));
  EXPECT_THAT(open({map_, "Robot 1"}),
              IsError(StatusCode::kInvalidArgument, "BAD_NAME", "open.robot"));
  EXPECT_THAT(open({map_, "robot-1", "../s"}),
              IsError(StatusCode::kInvalidArgument, "BAD_NAME", "open.session"));
}

TEST_P(UploadStreamTest, UnknownLevelIsRefused) {
  UploadClient client(&service_);
  EXPECT_THAT(
      client.Open(session_, {v1::ACK_LEVEL_DURABLE, static_cast<v1::AckLevel>(17)}).status(),
      IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "open.ack_levels[1]"));
}

TEST_P(UploadStreamTest, SequenceThatDoesNotRiseIsRefused) {
  UploadClient client(&service_);
  ASSERT_TRUE(client.Open(session_).ok());
  ASSERT_TRUE(client.Send(MakeBatch(5, 2)));
  client.Send(MakeBatch(6, 1));
  EXPECT_THAT(client.Finish(),
              IsError(StatusCode::kInvalidArgument, "BAD_SEQUENCE", "batch.first_client_seq"));
}

TEST_P(UploadStreamTest, NumberingThatCannotBeIsRefused) {
  const auto upload = [this](const v1::FrameBatch& batch) {
    return UploadAndClose(&service_, session_, batch);
  };
  EXPECT_THAT(upload(MakeBatch(0, 1)),
              IsError(StatusCode::kInvalidArgument, "BAD_SEQUENCE", "batch.first_client_seq"));
  v1::FrameBatch last = MakeBatch(1, 2);
  last.set_first_client_seq(~std::uint64_t{0});
  EXPECT_THAT(upload(last),
              IsError(StatusCode::kInvalidArgument, "BAD_SEQUENCE", "batch.first_client_seq"));
  EXPECT_THAT(upload(MakeBatch(1, 0)),
              IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "batch.frames"));
}

TEST_P(UploadStreamTest, ABatchOfTooManyFramesIsRefused) {
  v1::FrameBatch batch;
  batch.set_first_client_seq(1);
  for (int i = 0; i < 257; ++i) batch.add_frames();
  EXPECT_THAT(UploadAndClose(&service_, session_, batch),
              IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "batch.frames"));
  for (int i = 0; i < 100'000; ++i) batch.add_frames();
  EXPECT_THAT(UploadAndClose(&service_, session_, batch),
              IsError(StatusCode::kResourceExhausted, "MESSAGE_TOO_LARGE", ""));
}

TEST_P(UploadStreamTest, FramesThatTheStoreHasLostAreNamed) {
  ASSERT_TRUE(UploadAndClose(&service_, session_, MakeBatch(1, 3)).ok());
  UploadClient client(&service_);
  v1::UploadFramesRequest request;
  request.mutable_open()->set_map(map_);
  request.mutable_open()->set_robot(session_.robot);
  request.mutable_open()->set_session(session_.session);
  request.mutable_open()->set_last_durable_client_seq(7);
  client.Send(request);
  const std::optional<v1::UploadFramesResponse> response = client.Read();
  ASSERT_TRUE(response && response->has_opened());
  EXPECT_EQ(response->opened().resume_client_seq(), 3U);
  EXPECT_EQ(response->opened().lost().first(), 4U);
  EXPECT_EQ(response->opened().lost().last(), 7U);
  ASSERT_TRUE(client.Send(MakeBatch(4, 4)));
  EXPECT_TRUE(client.Close().ok());
  EXPECT_EQ(client.newest(v1::ACK_LEVEL_INTEGRATED).client_seq(), 7U);
}

TEST_P(UploadStreamTest, StateSaysHowFarTheSensorsClockIsAhead) {
  v1::FrameBatch batch = MakeBatch(1, 1);
  batch.mutable_frames(0)->mutable_capture_time()->set_seconds(time(nullptr) + 60);
  ASSERT_TRUE(UploadAndClose(&service_, session_, batch).ok());
  v1::GetUploadStateRequest request;
  request.set_map(map_);
  request.set_robot(session_.robot);
  request.set_session(session_.session);
  v1::UploadState state;
  ASSERT_TRUE(Call([&](auto* context) {
                return service_.ingest().GetUploadState(context, request, &state);
              }).ok());
  EXPECT_GT(state.capture_time_ahead().seconds(), 0);
  EXPECT_LE(state.capture_time_ahead().seconds(), 60);
}

TEST_P(UploadStreamTest, MoreFramesThanCreditIsRefused) {
  UploadClient client(&service_);
  const absl::StatusOr<v1::UploadOpened> opened = client.Open(session_);
  client.Send(MakeBatch(1, static_cast<int>(opened->credit().frames()) + 1));
  EXPECT_THAT(client.Finish(), IsError(StatusCode::kResourceExhausted, "QUEUE_FULL", ""));
}

TEST_P(UploadStreamTest, CreditComesBackWithIntegration) {
  UploadClient client(&service_);
  ASSERT_TRUE(client.Open(session_).ok());
  const v1::FrameBatch batch = MakeBatch(1, 32);
  ASSERT_TRUE(client.Send(batch));
  while (client.credit().frames() < 32) ASSERT_TRUE(client.Read());
  EXPECT_EQ(client.credit().bytes(), batch.ByteSizeLong());
  EXPECT_EQ(client.newest(v1::ACK_LEVEL_INTEGRATED).client_seq(), 32U);
}

TEST_P(UploadStreamTest, SecondStreamOfTheRobotSupersedesTheFirst) {
  UploadClient first(&service_);
  ASSERT_TRUE(first.Open(session_).ok());
  ASSERT_TRUE(first.Send(MakeBatch(1, 2)));
  ASSERT_TRUE(first.ReadUntil(v1::ACK_LEVEL_DURABLE, 2));
  UploadClient second(&service_);
  EXPECT_EQ(second.Open(session_)->resume_client_seq(), 2U);
  EXPECT_THAT(first.Finish(), IsError(StatusCode::kAborted, "UPLOAD_SUPERSEDED", ""));
  ASSERT_TRUE(second.Send(MakeBatch(3, 1)));
  EXPECT_TRUE(second.Close().ok());
  EXPECT_EQ(service_.GetMap(map_)->state().revision(), 3U);
}

TEST_P(UploadStreamTest, AnotherRobotOrMapDoesNotSupersede) {
  UploadClient first(&service_);
  ASSERT_TRUE(first.Open(session_).ok());
  UploadClient other_robot(&service_);
  ASSERT_TRUE(other_robot.Open({map_, "robot-2"}).ok());
  UploadClient other_map(&service_);
  ASSERT_TRUE(other_map.Open({service_.CreateMap("yard")}).ok());
  EXPECT_TRUE(first.Close().ok());
  EXPECT_TRUE(other_robot.Close().ok());
  EXPECT_TRUE(other_map.Close().ok());
}

TEST_P(UploadStreamTest, RepeatedFramesCountOnceAndAreAcknowledged) {
  ASSERT_TRUE(UploadAndClose(&service_, session_, MakeBatch(1, 4)).ok());
  UploadClient client(&service_);
  EXPECT_EQ(client.Open(session_)->resume_client_seq(), 4U);
  ASSERT_TRUE(client.Send(MakeBatch(2, 4)));
  EXPECT_TRUE(client.Close().ok());
  EXPECT_EQ(client.newest(v1::ACK_LEVEL_INTEGRATED).client_seq(), 5U);
  EXPECT_EQ(service_.GetMap(map_)->state().revision(), 5U);
}

TEST_P(UploadStreamTest, OnlyRepeatedFramesAreAcknowledgedAsIntegrated) {
  ASSERT_TRUE(UploadAndClose(&service_, session_, MakeBatch(1, 4)).ok());
  UploadClient client(&service_);
  ASSERT_TRUE(client.Open(session_).ok());
  ASSERT_TRUE(client.Send(MakeBatch(1, 4)));
  const std::optional<v1::UploadAck> ack = client.ReadUntil(v1::ACK_LEVEL_INTEGRATED, 4);
  ASSERT_TRUE(ack);
  EXPECT_EQ(ack->revision(), 4U);
  EXPECT_TRUE(client.Close().ok());
  EXPECT_EQ(service_.GetMap(map_)->state().durable_map_seq(), 4U);
}

TEST_P(UploadStreamTest, RestartGoesOnBehindTheResumePointAndCountsOnce) {
  {
    UploadClient client(&service_);
    ASSERT_TRUE(client.Open(session_).ok());
    ASSERT_TRUE(client.Send(MakeBatch(1, 5)));
    // Durable, but not integrated: no commit is due.
    ASSERT_TRUE(client.ReadUntil(v1::ACK_LEVEL_DURABLE, 5));
  }
  service_.Restart();
  UploadClient client(&service_);
  EXPECT_EQ(client.Open(session_)->resume_client_seq(), 5U);
  ASSERT_TRUE(client.Send(MakeBatch(4, 4)));
  EXPECT_TRUE(client.Close().ok());
  EXPECT_EQ(client.newest(v1::ACK_LEVEL_INTEGRATED).client_seq(), 7U);
  EXPECT_EQ(service_.GetMap(map_)->state().revision(), 7U);
}

TEST_P(UploadStreamTest, ClientThatVanishesLeavesItsDurableFrames) {
  {
    UploadClient client(&service_);
    ASSERT_TRUE(client.Open(session_).ok());
    ASSERT_TRUE(client.Send(MakeBatch(1, 2)));
    ASSERT_TRUE(client.ReadUntil(v1::ACK_LEVEL_DURABLE, 2));
    client.Send(MakeBatch(3, 8));
    client.Cancel();
    EXPECT_EQ(client.Finish().code(), StatusCode::kCancelled);
  }
  UploadClient client(&service_);
  EXPECT_GE(client.Open(session_)->resume_client_seq(), 2U);
  ASSERT_TRUE(client.Send(MakeBatch(3, 8)));
  EXPECT_TRUE(client.Close().ok());
  EXPECT_EQ(service_.GetMap(map_)->state().revision(), 10U);
}

TEST_P(UploadStreamTest, DeletingTheMapEndsItsUploads) {
  UploadClient client(&service_);
  ASSERT_TRUE(client.Open(session_).ok());
  ASSERT_TRUE(client.Send(MakeBatch(1, 8)));
  ASSERT_TRUE(service_.DeleteMap(map_).ok());
  EXPECT_THAT(client.Finish(), IsError(StatusCode::kNotFound, "NOT_FOUND", ""));
  // The new map of this name starts empty.
  service_.CreateMap("hall");
  UploadClient anew(&service_);
  EXPECT_EQ(anew.Open(session_)->resume_client_seq(), 0U);
}

TEST_P(UploadStreamTest, DrainAcknowledgesWhatWasTakenAndEndsStreams) {
  UploadClient client(&service_);
  ASSERT_TRUE(client.Open(session_).ok());
  ASSERT_TRUE(client.Send(MakeBatch(1, 3)));
  ASSERT_TRUE(client.ReadUntil(v1::ACK_LEVEL_DURABLE, 3));
  service_.server().Drain();
  EXPECT_THAT(client.Finish(), IsError(StatusCode::kUnavailable, "DRAINING", ""));
  EXPECT_EQ(client.newest(v1::ACK_LEVEL_INTEGRATED).client_seq(), 3U);
  UploadClient late(&service_);
  EXPECT_THAT(late.Open(session_).status(), IsError(StatusCode::kUnavailable, "DRAINING", ""));
  // Reading continues.
  EXPECT_EQ(service_.GetMap(map_)->state().revision(), 3U);
}

TEST_P(UploadStreamTest, TwoRobotsAtOnceBothGetIntegrated) {
  UploadClient first(&service_);
  UploadClient second(&service_);
  ASSERT_TRUE(first.Open({map_, "robot-1"}).ok());
  ASSERT_TRUE(second.Open({map_, "robot-2"}).ok());
  for (std::uint64_t batch = 0; batch < 6; ++batch) {
    ASSERT_TRUE(first.Send(MakeBatch(1 + 4 * batch, 4)));
    ASSERT_TRUE(second.Send(MakeBatch(1 + 4 * batch, 4)));
  }
  first.HalfClose();
  EXPECT_TRUE(second.Close().ok());
  EXPECT_TRUE(first.Finish().ok());
  EXPECT_EQ(service_.GetMap(map_)->state().revision(), 48U);
}

TEST_P(UploadStreamTest, StreamsBeyondTheBoundAreRefusedUntilOneEnds) {
  TestService service(GetParam(),
                      [](ServerConfig* config) { config->limits.max_upload_streams = 2; });
  const std::string map = service.CreateMap("hall");
  UploadClient first(&service);
  ASSERT_TRUE(first.Open({map, "robot-1"}).ok());
  UploadClient second(&service);
  ASSERT_TRUE(second.Open({map, "robot-2"}).ok());
  {
    UploadClient third(&service);
    const absl::Status refused = third.Open({map, "robot-3"}).status();
    EXPECT_EQ(refused.code(), StatusCode::kResourceExhausted) << refused;
    EXPECT_EQ(ReasonOf(refused), "QUEUE_FULL");
    EXPECT_GT(RetryDelayMsOf(refused), 0);
  }
  // A reconnecting robot replaces its previous stream.
  UploadClient again(&service);
  EXPECT_TRUE(again.Open({map, "robot-2"}).ok());
  EXPECT_EQ(ReasonOf(second.Finish()), "UPLOAD_SUPERSEDED");
  EXPECT_TRUE(first.Close().ok());
  // The client may receive the end before the server has released the stream.
  EXPECT_TRUE(testing::Eventually([&] {
    UploadClient third(&service);
    return third.Open({map, "robot-3"}).ok();
  }));
}

TEST_P(UploadStreamTest, StateTellsWhereTheSessionStands) {
  ASSERT_TRUE(UploadAndClose(&service_, session_, MakeBatch(1, 4)).ok());
  UploadClient client(&service_);
  ASSERT_TRUE(client.Open(session_).ok());
  ASSERT_TRUE(client.Send(MakeBatch(5, 2)));
  ASSERT_TRUE(client.ReadUntil(v1::ACK_LEVEL_DURABLE, 6));
  v1::GetUploadStateRequest request;
  request.set_map(map_);
  request.set_robot(session_.robot);
  request.set_session(session_.session);
  v1::UploadState state;
  const auto get = [&](auto* context) {
    return service_.ingest().GetUploadState(context, request, &state);
  };
  ASSERT_TRUE(Call(get).ok());
  EXPECT_EQ(state.resume_client_seq(), 6U);
  EXPECT_EQ(state.integrated_client_seq(), 4U);
  EXPECT_TRUE(state.has_last_frame_time());
  request.set_session("another");
  state.Clear();
  ASSERT_TRUE(Call(get).ok());
  EXPECT_EQ(state.resume_client_seq(), 0U);
  EXPECT_FALSE(state.has_last_frame_time());
  request.set_robot("");
  EXPECT_THAT(Call(get), IsError(StatusCode::kInvalidArgument, "BAD_NAME", "robot"));
}

}  // namespace
}  // namespace steadymap
