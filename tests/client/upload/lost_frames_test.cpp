// Tests uploads to a server that has lost frames that it had acknowledged as durable.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "client/upload/frame_replay.h"
#include "core/types/error.h"
#include "proto/convert_status.h"
#include "tests/client/upload/upload_harness.h"

namespace steadymap {
namespace {

/// Returns a frame with `number` bytes of depth, so that frames are distinguishable.
v1::Frame NumberedFrame(std::uint64_t number) { return FrameOfBytes(number); }

/// Accepts all frames and records the depth size of each sequence.
grpc::Status AcceptAndNote(ScriptedStream& stream, std::map<std::uint64_t, std::size_t>* depths) {
  v1::FrameBatch batch;
  while (stream.ReadBatch(&batch)) {
    for (int i = 0; i < batch.frames_size(); ++i) {
      (*depths)[batch.first_client_seq() + static_cast<std::uint64_t>(i)] =
          batch.frames(i).depth().data().size();
    }
    stream.SendAck(v1::ACK_LEVEL_DURABLE, stream.received().back());
    stream.SendCredit(static_cast<std::uint64_t>(batch.frames_size()), batch.ByteSizeLong());
  }
  if (!stream.received().empty()) {
    stream.SendAck(v1::ACK_LEVEL_INTEGRATED, stream.received().back());
  }
  return grpc::Status::OK;
}

v1::RefusedFrame Refused(std::uint64_t client_seq) {
  v1::RefusedFrame refused;
  refused.set_client_seq(client_seq);
  *refused.mutable_status() = ToProto(InvalidField(reason::kBadValue, "frames[0]", "broken"));
  return refused;
}

/// Frames 1 to 6 arrive, 3 is refused, 5 are integrated; then the connection breaks, and the server
/// returns with the frames up to 2.
class LostFramesTest : public ::testing::Test {
 protected:
  static grpc::Status TakeSix(ScriptedStream& stream) {
    stream.ReadOpen();
    stream.SendOpened(0, 100);
    EXPECT_TRUE(stream.ReadUntil(6));
    stream.SendAck(v1::ACK_LEVEL_DURABLE, 6, {Refused(3)});
    stream.SendAck(v1::ACK_LEVEL_INTEGRATED, 5);
    return Failure(absl::StatusCode::kUnavailable);
  }

  grpc::Status ComeBackWithTwo(ScriptedStream& stream) {
    reopened_behind_ = stream.ReadOpen().last_durable_client_seq();
    stream.SendOpened(2, 100);
    grpc::Status status = AcceptAndNote(stream, &depths_);
    received_ = stream.received();
    return status;
  }

  absl::StatusOr<UploadSummary> Upload(std::uint64_t frame_count) {
    FrameUploader uploader(harness_.server.channels(), kKitchen, harness_.options);
    for (std::uint64_t number = 1; number <= frame_count; ++number) {
      if (absl::Status status = uploader.Push(NumberedFrame(number)); !status.ok()) return status;
    }
    return uploader.Finish();
  }

  void NoteLosses() {
    harness_.options.on_lost = [this](const LostFrames& lost) { lost_.push_back(lost); };
  }

  std::map<std::uint64_t, std::size_t> depths_;
  std::vector<std::uint64_t> received_;
  std::uint64_t reopened_behind_ = 0;
  std::vector<LostFrames> lost_;
  UploadHarness harness_{
      {TakeSix, [this](ScriptedStream& stream) { return ComeBackWithTwo(stream); }}};
};

TEST_F(LostFramesTest, ThatCanBeReadAgainAreSentAgainInTheirOrder) {
  NoteLosses();
  harness_.options.max_batch_frames = 3;
  harness_.options.read_again = [](std::uint64_t client_seq) { return NumberedFrame(client_seq); };
  const absl::StatusOr<UploadSummary> summary = Upload(8);
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(reopened_behind_, 6U);
  EXPECT_EQ(received_, Sequences(3, 8));
  for (const auto& [client_seq, depth_bytes] : depths_) EXPECT_EQ(depth_bytes, client_seq);
  EXPECT_EQ(lost_, (std::vector<LostFrames>{{3, 6}}));
  const UploadProgress& progress = summary->progress;
  EXPECT_EQ(progress.pushed, 8U);
  EXPECT_EQ(progress.refused, 1U) << "frame 3 counts once";
  EXPECT_EQ(progress.integrated, 7U);
  EXPECT_EQ(progress.durable, 7U);
  EXPECT_EQ(progress.lost, 0U);
  EXPECT_GE(progress.sent_again, 4U);
  EXPECT_TRUE(summary->lost.empty());
}

TEST_F(LostFramesTest, ThatAreLostTwiceAreSentTwice) {
  harness_.service.SetScripts({TakeSix,
                               [](ScriptedStream& stream) {
                                 stream.ReadOpen();
                                 stream.SendOpened(4, 100);
                                 EXPECT_TRUE(stream.ReadUntil(5));
                                 return Failure(absl::StatusCode::kUnavailable);
                               },
                               [this](ScriptedStream& stream) { return ComeBackWithTwo(stream); }});
  NoteLosses();
  harness_.options.read_again = [](std::uint64_t client_seq) { return NumberedFrame(client_seq); };
  const absl::StatusOr<UploadSummary> summary = Upload(6);
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(received_, Sequences(3, 6));
  EXPECT_EQ(lost_, (std::vector<LostFrames>{{5, 6}, {3, 4}}));
  EXPECT_EQ(summary->progress.integrated, 5U);
}

TEST_F(LostFramesTest, ThatCannotBeReadAgainEndTheUpload) {
  harness_.options.read_again = [](std::uint64_t client_seq) -> absl::StatusOr<v1::Frame> {
    if (client_seq == 5) return absl::NotFoundError("0005.png is missing");
    return NumberedFrame(client_seq);
  };
  const absl::Status status = Upload(6).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss);
  EXPECT_NE(status.message().find("frame 5"), std::string::npos) << status;
  EXPECT_NE(status.message().find("0005.png is missing"), std::string::npos) << status;
}

TEST_F(LostFramesTest, ThatAreGoneAreCountedAndTheUploadGoesOnBehindThem) {
  NoteLosses();
  const absl::StatusOr<UploadSummary> summary = Upload(8);
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(received_, Sequences(7, 8));
  EXPECT_EQ(lost_, (std::vector<LostFrames>{{3, 6}}));
  EXPECT_EQ(summary->lost, lost_);
  const UploadProgress& progress = summary->progress;
  EXPECT_EQ(progress.lost, 3U) << "frame 3 had been refused";
  EXPECT_EQ(progress.refused, 1U);
  EXPECT_EQ(progress.integrated, 4U);
  EXPECT_EQ(progress.durable, 4U);
}

TEST_F(LostFramesTest, ThatAreTheLastOnesDoNotKeepTheUploadFromItsEnd) {
  NoteLosses();
  harness_.service.state.set_resume_client_seq(2);
  harness_.service.state.set_integrated_client_seq(2);
  const absl::StatusOr<UploadSummary> summary = Upload(6);
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_TRUE(received_.empty());
  EXPECT_EQ(summary->progress.lost, 3U);
  EXPECT_EQ(summary->progress.integrated, 2U);
}

TEST_F(LostFramesTest, AreToldOnceThoughTheServerSaysItAgain) {
  const auto come_back_and_break = [](ScriptedStream& stream) {
    stream.ReadOpen();
    stream.SendOpened(2, 100);
    return Failure(absl::StatusCode::kUnavailable);
  };
  harness_.service.SetScripts({TakeSix, come_back_and_break, [this](ScriptedStream& stream) {
                                 return ComeBackWithTwo(stream);
                               }});
  NoteLosses();
  const absl::StatusOr<UploadSummary> summary = Upload(8);
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(lost_.size(), 1U);
  EXPECT_EQ(summary->progress.lost, 3U);
}

// A source with the frames 1 to 3; the second is unreadable.
class GappySource final : public FrameSource {
 public:
  std::size_t frame_count() const override { return 3; }

  absl::StatusOr<std::optional<v1::Frame>> Next() override {
    if (next_ == 3) return std::nullopt;
    absl::StatusOr<v1::Frame> frame = Read(next_++);
    if (!frame.ok()) return frame.status();
    return std::optional<v1::Frame>(*std::move(frame));
  }

  absl::StatusOr<v1::Frame> Read(std::size_t index) override {
    if (index == 1) return absl::NotFoundError("0001.png is missing");
    return NumberedFrame(index + 1);
  }

 private:
  std::size_t next_ = 0;
};

TEST(FrameReplay, KnowsWhichFramesWerePushed) {
  GappySource source;
  FrameReplay replay(&source);
  EXPECT_EQ(replay.ReadPushed(1).status().code(), absl::StatusCode::kOutOfRange);
  for (int i = 0; i < 4; ++i) static_cast<void>(replay.Next());
  EXPECT_EQ(replay.ReadPushed(1)->depth().data().size(), 1U);
  EXPECT_EQ(replay.ReadPushed(2)->depth().data().size(), 3U);
  for (const std::uint64_t client_seq : {0U, 3U}) {
    EXPECT_EQ(replay.ReadPushed(client_seq).status().code(), absl::StatusCode::kOutOfRange);
  }
}

}  // namespace
}  // namespace steadymap
