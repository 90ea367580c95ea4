#include "server/upload/upload_responses.h"

#include <gtest/gtest.h>

#include "core/types/error.h"

namespace steadymap {
namespace {

BatchProgress Progress(std::uint64_t through, std::size_t frames = 0, std::uint64_t bytes = 0) {
  BatchProgress progress;
  progress.through = ClientSequence(through);
  progress.map_seq = MapSequence(through);
  progress.revision = Revision(through);
  progress.frames = frames;
  progress.bytes = bytes;
  return progress;
}

UploadResponses MakeAnswers(const std::vector<v1::AckLevel>& levels = {}) {
  UploadResponses answers({10, 1000});
  v1::UploadOpen open;
  for (const v1::AckLevel level : levels) open.add_ack_levels(level);
  EXPECT_TRUE(answers.ChooseLevels(open).ok());
  return answers;
}

TEST(UploadResponses, SlowReaderGetsTheNewestOfEachLevel) {
  UploadResponses answers = MakeAnswers();
  EXPECT_FALSE(answers.HasNext());
  for (std::uint64_t i = 1; i <= 5; ++i) answers.NoteDurable(Progress(i));
  answers.NoteIntegrated(Progress(3, 3, 30));
  v1::UploadFramesResponse next = answers.TakeNext();
  EXPECT_EQ(next.ack().level(), v1::ACK_LEVEL_DURABLE);
  EXPECT_EQ(next.ack().client_seq(), 5U);
  EXPECT_EQ(next.ack().revision(), 0U);
  next = answers.TakeNext();
  EXPECT_EQ(next.ack().level(), v1::ACK_LEVEL_INTEGRATED);
  EXPECT_EQ(next.ack().client_seq(), 3U);
  EXPECT_EQ(next.ack().revision(), 3U);
  next = answers.TakeNext();
  EXPECT_EQ(next.credit().frames(), 3U);
  EXPECT_EQ(next.credit().bytes(), 30U);
  EXPECT_FALSE(answers.HasNext());
}

TEST(UploadResponses, IntegratedImpliesDurable) {
  UploadResponses answers = MakeAnswers();
  answers.NoteIntegrated(Progress(4, 1, 1));
  EXPECT_EQ(answers.TakeNext().ack().level(), v1::ACK_LEVEL_DURABLE);
  EXPECT_EQ(answers.TakeNext().ack().level(), v1::ACK_LEVEL_INTEGRATED);
}

TEST(UploadResponses, WordThatComesLateChangesNothing) {
  UploadResponses answers = MakeAnswers({v1::ACK_LEVEL_DURABLE});
  answers.NoteDurable(Progress(4));
  EXPECT_EQ(answers.TakeNext().ack().client_seq(), 4U);
  answers.NoteDurable(Progress(3));
  EXPECT_FALSE(answers.HasNext());
}

TEST(UploadResponses, RefusalsAreReportedOnceAtTheLowestLevel) {
  UploadResponses answers = MakeAnswers();
  std::vector<RefusedFrame> refused;
  for (const std::uint64_t sequence : {2U, 6U}) {
    refused.push_back({ClientSequence(sequence), InvalidField("BAD_VALUE", "frames[1]", "no")});
  }
  answers.NoteReceived(ClientSequence(6), refused);
  EXPECT_FALSE(answers.HasNext());
  answers.NoteDurable(Progress(4));
  v1::UploadFramesResponse next = answers.TakeNext();
  ASSERT_EQ(next.ack().refused_size(), 1);
  EXPECT_EQ(next.ack().refused(0).client_seq(), 2U);
  answers.NoteIntegrated(Progress(6));
  next = answers.TakeNext();
  EXPECT_EQ(next.ack().level(), v1::ACK_LEVEL_DURABLE);
  ASSERT_EQ(next.ack().refused_size(), 1);
  EXPECT_EQ(next.ack().refused(0).client_seq(), 6U);
  EXPECT_EQ(answers.TakeNext().ack().refused_size(), 0);
}

TEST(UploadResponses, CreditCountsOnceItIsGiven) {
  UploadResponses answers = MakeAnswers();
  EXPECT_TRUE(answers.Spend(10, 500).ok());
  EXPECT_EQ(ReasonOf(answers.Spend(1, 1)), "QUEUE_FULL");
  answers.NoteIntegrated(Progress(4, 4, 100));
  // Not sent yet, so the client cannot use it.
  EXPECT_FALSE(answers.Spend(1, 1).ok());
  while (answers.HasNext()) answers.TakeNext();
  EXPECT_TRUE(answers.Spend(4, 600).ok());
  EXPECT_FALSE(answers.Spend(0, 1).ok());
}

TEST(UploadResponses, UnknownLevelIsRefusedByItsPlace) {
  UploadResponses answers({10, 1000});
  v1::UploadOpen open;
  open.add_ack_levels(v1::ACK_LEVEL_DURABLE);
  open.add_ack_levels(v1::ACK_LEVEL_UNSPECIFIED);
  EXPECT_EQ(FieldOf(answers.ChooseLevels(open)), "ack_levels[1]");
}

}  // namespace
}  // namespace steadymap
