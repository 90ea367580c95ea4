// Tests watchers that are disconnected within a step, keep the received part of it, and resume
// after that part.

#include <cstdint>
#include <optional>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/contract/object_map.h"
#include "tests/contract/watch_fixture.h"

namespace steadymap {
namespace {

/// Returns the resume token of a message of a step; empty for others.
std::string PartToken(const v1::WatchMapResponse& message) {
  if (message.has_snapshot()) return message.snapshot().resume_token();
  if (message.has_delta()) return message.delta().resume_token();
  return message.events().resume_token();
}

class WatchPartTest : public WatchServiceTest {
 protected:
  WatchPartTest() { StoreMap(&service_, MakeCrowdedMap(40), {}); }

  /// Requests many small messages.
  v1::WatchMapRequest SmallMessages(v1::WatchMapRequest request) const {
    request.set_max_message_bytes(65'536);
    return request;
  }

  v1::WatchMapRequest GoOnBehind(const std::string& token) const {
    v1::WatchMapRequest request = SmallMessages(Request(v1::WATCH_START_UNSPECIFIED));
    request.set_resume_token(token);
    return request;
  }

  /// The received part of a step.
  struct Part {
    ToldStep step;
    std::string token;  ///< Resumes after the part.
    int messages = 0;
  };

  /// Opens a watch, reads one message of its first step, and cancels it; the progress completes the
  /// step. Returns `created`.
  v1::WatchCreated TakeOne(const v1::WatchMapRequest& request, Part* part) {
    const auto watch = Watch(request);
    const auto created = watch->Read();
    EXPECT_TRUE(created.has_value());
    const auto message = watch->Read();
    if (!created || !message) return {};
    ++part->messages;
    if (message->has_snapshot()) part->step.snapshot.push_back(message->snapshot());
    if (message->has_delta()) part->step.delta.push_back(message->delta());
    if (message->has_progress()) part->step.progress = message->progress();
    part->token = PartToken(*message);
    return created->created();
  }

  /// Reads a step with one message per stream and calls `meanwhile` between the streams.
  template <typename Meanwhile>
  Part TakePieceByPiece(const v1::WatchMapRequest& request, const Meanwhile& meanwhile) {
    Part part;
    v1::WatchCreated created = TakeOne(request, &part);
    const std::uint64_t begun_at = created.revision();
    EXPECT_FALSE(created.continues_step());
    while (!part.step.progress.has_last_capture_time()) {
      if (part.token.empty()) {
        ADD_FAILURE() << "message " << part.messages << " has no token";
        break;
      }
      meanwhile();
      created = TakeOne(GoOnBehind(part.token), &part);
      EXPECT_TRUE(created.continues_step());
      EXPECT_EQ(created.revision(), begun_at);
    }
    return part;
  }
};

INSTANTIATE_TEST_SUITE_P(Transports,
                         WatchPartTest,
                         ::testing::Values(Transport::kInProcess, Transport::kLoopback),
                         TransportName);

TEST_P(WatchPartTest, ASnapshotComesPieceByPieceThoughTheMapMovesOn) {
  const std::vector<std::string> leaves = LeavesByQuery();
  uploaded_ = kObjectMapRevision;
  const Part part = TakePieceByPiece(SmallMessages(Request()), [this] { Upload(1); });
  EXPECT_GE(part.messages, 5);
  EXPECT_EQ(part.step.progress.revision(), kObjectMapRevision);
  ToldLeaves view;
  view.Take(part.step);
  EXPECT_EQ(view.All(), leaves) << "as the map was at the snapshot's revision";
  const auto rest = Watch(ResumeBehind(part.step.progress))->ReadUntil(uploaded_);
  ASSERT_TRUE(rest.has_value());
  view.Take(*rest);
  EXPECT_EQ(view.All(), LeavesByQuery());
}

TEST_P(WatchPartTest, ALongDeltaComesPieceByPieceThoughTheMapMovesOn) {
  uploaded_ = kObjectMapRevision;
  const auto begin = Watch(Request())->ReadStep();
  ASSERT_TRUE(begin.has_value());
  ToldLeaves view;
  view.Take(*begin);
  const std::uint64_t target = Upload(20);
  const std::vector<std::string> leaves = LeavesByQuery();
  const Part part =
      TakePieceByPiece(SmallMessages(ResumeBehind(begin->progress)), [this] { Upload(1); });
  EXPECT_GE(part.messages, 4);
  EXPECT_EQ(part.step.progress.revision(), target);
  view.Take(part.step);
  EXPECT_EQ(view.All(), leaves);
}

TEST_P(WatchPartTest, AStepThatWasSentToItsEndCanBeGoneOnWithin) {
  uploaded_ = kObjectMapRevision;
  const auto begin = Watch(Request())->ReadStep();
  ASSERT_TRUE(begin.has_value());
  Upload(20);
  // The messages after the first count as lost in transit.
  auto watch = Watch(SmallMessages(ResumeBehind(begin->progress)));
  watch->Read();
  const auto first = watch->Read();
  ASSERT_TRUE(first.has_value());
  const auto lost = watch->ReadStep();
  ASSERT_TRUE(lost.has_value());
  watch.reset();
  Upload(1);
  const auto again = Watch(GoOnBehind(PartToken(*first)))->ReadStep();
  ASSERT_TRUE(again.has_value());
  EXPECT_TRUE(again->created->continues_step());
  EXPECT_EQ(again->progress.revision(), lost->progress.revision());
  ASSERT_EQ(again->delta.size(), lost->delta.size());
  for (std::size_t i = 0; i < again->delta.size(); ++i) {
    EXPECT_EQ(again->delta[i].SerializeAsString(), lost->delta[i].SerializeAsString());
  }
}

TEST_P(WatchPartTest, TheSnapshotOfAMapThatRestsGoesOnAfterARestart) {
  const Part part = TakePieceByPiece(SmallMessages(Request()), [this] { service_.Restart(); });
  EXPECT_GE(part.messages, 5);
  ToldLeaves view;
  view.Take(part.step);
  EXPECT_EQ(view.All(), LeavesByQuery());
}

TEST_P(WatchPartTest, ASnapshotThatIsGoneBeginsAnew) {
  uploaded_ = kObjectMapRevision;
  Part part;
  TakeOne(SmallMessages(Request()), &part);
  const std::uint64_t revision = Upload(1);
  service_.Restart();
  const auto watch = Watch(GoOnBehind(part.token));
  const auto begin = watch->ReadStep();
  ASSERT_TRUE(begin.has_value());
  EXPECT_FALSE(begin->created->continues_step());
  EXPECT_EQ(begin->created->revision(), revision);
  ToldLeaves view;
  view.Take(*begin);
  EXPECT_EQ(view.All(), LeavesByQuery());
}

TEST_P(WatchPartTest, ADeltaThatIsGoneBeginsAnew) {
  uploaded_ = kObjectMapRevision;
  const auto begin = Watch(Request())->ReadStep();
  ASSERT_TRUE(begin.has_value());
  Upload(20);
  Part part;
  TakeOne(SmallMessages(ResumeBehind(begin->progress)), &part);
  service_.Restart();
  const auto created = Watch(GoOnBehind(part.token))->Read();
  ASSERT_TRUE(created.has_value());
  EXPECT_FALSE(created->created().continues_step());
  EXPECT_EQ(created->created().revision(), begin->progress.revision());
}

TEST_P(WatchPartTest, MessagesOfAnotherSizeAreAnotherStep) {
  Part part;
  TakeOne(SmallMessages(Request()), &part);
  v1::WatchMapRequest request = GoOnBehind(part.token);
  request.set_max_message_bytes(131'072);
  const auto begin = Watch(request)->ReadStep();
  ASSERT_TRUE(begin.has_value());
  EXPECT_FALSE(begin->created->continues_step());
  ToldLeaves view;
  view.Take(*begin);
  EXPECT_EQ(view.All(), LeavesByQuery());
}

TEST_P(WatchPartTest, SmallStepsCarryNoTokensWithin) {
  uploaded_ = kObjectMapRevision;
  const auto watch = Watch(Request());
  ASSERT_TRUE(watch->ReadStep().has_value());
  v1::WatchMapRequest objects = Request();
  objects.mutable_filter()->add_class_ids(101);
  const auto begin = Watch(objects)->ReadStep();
  ASSERT_TRUE(begin.has_value());
  ASSERT_EQ(begin->snapshot.size(), 1U);
  EXPECT_EQ(begin->snapshot[0].resume_token(), "");
}

}  // namespace
}  // namespace steadymap
