// Tests mirrors whose streams break within a long step and that resume after the received part.

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/client/map/mirror_harness.h"

namespace steadymap {
namespace {

using watching::ContentOf;
using watching::Created;
using watching::DeltaOf;
using watching::Events;
using watching::FirstMap;
using watching::Join;
using watching::Messages;
using watching::Progress;
using watching::Resync;
using watching::SecondMap;
using watching::SnapshotOf;

/// Adds a resume token to each part of a step: "p1", "p2" and so on.
Messages WithTokens(Messages parts) {
  int number = 0;
  for (v1::WatchMapResponse& part : parts) {
    const std::string token = "p" + std::to_string(++number);
    if (part.has_snapshot()) part.mutable_snapshot()->set_resume_token(token);
    if (part.has_delta()) part.mutable_delta()->set_resume_token(token);
    if (part.has_events()) part.mutable_events()->set_resume_token(token);
  }
  return parts;
}

/// Returns the first `count` messages.
Messages Head(const Messages& messages, std::ptrdiff_t count) {
  return {messages.begin(), messages.begin() + count};
}

Messages Tail(const Messages& messages, std::ptrdiff_t count) {
  return {messages.begin() + count, messages.end()};
}

/// Returns the `created` of a stream that continues a step.
Messages Continued(const MapSnapshot& map) {
  Messages created = Created(map);
  created[0].mutable_created()->set_continues_step(true);
  return created;
}

class UnfinishedStep : public ::testing::Test {
 protected:
  /// Returns the script of a server that sends these messages and breaks the stream.
  FakeWatchService::Script Cut(const Messages& messages) {
    return [messages](ScriptedWatch& watch) {
      watch.Send(messages);
      return WatchFailure(absl::StatusCode::kUnavailable);
    };
  }

  /// Returns the script of a server that sends these messages and keeps the stream open.
  FakeWatchService::Script Stay(const Messages& messages) {
    return [messages](ScriptedWatch& watch) {
      watch.Send(messages);
      return watch.Hold();
    };
  }

  Messages WholeFirst() const {
    return Join({Created(first_), SnapshotOf(first_), Progress(5, "t5")});
  }

  std::vector<std::string> Tokens() const {
    std::vector<std::string> tokens;
    for (const v1::WatchMapRequest& request : harness_.service.requests()) {
      tokens.push_back(request.resume_token());
    }
    return tokens;
  }

  const MapSnapshot first_ = FirstMap();
  const MapSnapshot second_ = SecondMap();
  const Messages snapshot_ = WithTokens(SnapshotOf(first_, 5));
  const Messages delta_ = WithTokens(Join({DeltaOf(first_, second_, 3), Events(6, {1, 2})}));
  MirrorHarness harness_;
};

TEST_F(UnfinishedStep, OfASnapshotGoesOnOverSeveralStreams) {
  ASSERT_GE(snapshot_.size(), 4U);
  MapMirror& mirror =
      harness_.Start({Cut(Join({Created(first_), Head(snapshot_, 1)})),
                      Cut(Join({Continued(first_), Head(Tail(snapshot_, 1), 1)})),
                      Cut({}),
                      Stay(Join({Continued(first_), Tail(snapshot_, 2), Progress(5, "t5")}))});
  ASSERT_TRUE(mirror.AwaitRevision(Revision(5), kHangTimeout).ok());
  EXPECT_EQ(ContentOf(*mirror.snapshot()), ContentOf(first_));
  EXPECT_EQ(mirror.resume_token(), "t5");
  harness_.AwaitSteps(1);
  EXPECT_EQ(harness_.steps().size(), 1U);
  EXPECT_EQ(Tokens(), (std::vector<std::string>{"", "p1", "p2", "p2"}));
  EXPECT_EQ(harness_.service.requests()[1].start(), v1::WATCH_START_UNSPECIFIED);
}

TEST_F(UnfinishedStep, OfASnapshotThatIsGoneBeginsAnew) {
  MapMirror& mirror =
      harness_.Start({Cut(Join({Created(first_), Head(snapshot_, 2)})),
                      Stay(Join({Created(second_), SnapshotOf(second_), Progress(6, "t6")}))});
  ASSERT_TRUE(mirror.AwaitRevision(Revision(6), kHangTimeout).ok());
  EXPECT_EQ(ContentOf(*mirror.snapshot()), ContentOf(second_)) << "nothing is left of the part";
  EXPECT_EQ(Tokens(), (std::vector<std::string>{"", "p2"}));
}

TEST_F(UnfinishedStep, OfASnapshotThatBeginsAnewAndIsCutAtOnceIsAskedForAgain) {
  MapMirror& mirror =
      harness_.Start({Cut(Join({Created(first_), Head(snapshot_, 2)})),
                      Cut(Created(second_)),
                      Cut(Join({Created(second_), Head(snapshot_, 0)})),
                      Stay(Join({Created(second_), SnapshotOf(second_), Progress(6, "t6")}))});
  ASSERT_TRUE(mirror.AwaitRevision(Revision(6), kHangTimeout).ok());
  EXPECT_EQ(ContentOf(*mirror.snapshot()), ContentOf(second_));
  EXPECT_EQ(Tokens(), (std::vector<std::string>{"", "p2", "", ""}));
  EXPECT_EQ(harness_.service.requests()[2].start(), v1::WATCH_START_SNAPSHOT_THEN_FOLLOW);
}

TEST_F(UnfinishedStep, OfADeltaGoesOnAndIsNotSeenBefore) {
  watching::MapContent between;
  MapMirror& mirror =
      harness_.Start({Cut(Join({WholeFirst(), Head(delta_, 2)})), [&](ScriptedWatch& watch) {
                        between = ContentOf(*harness_.mirror().snapshot());
                        watch.Send(Join({Continued(first_), Tail(delta_, 2), Progress(6, "t6")}));
                        return watch.Hold();
                      }});
  ASSERT_TRUE(mirror.AwaitRevision(Revision(6), kHangTimeout).ok());
  EXPECT_EQ(between, ContentOf(first_));
  EXPECT_EQ(ContentOf(*mirror.snapshot()), ContentOf(second_));
  harness_.AwaitEvents(2);
  EXPECT_EQ(harness_.event_numbers(), (std::vector<std::uint64_t>{1, 2}));
  EXPECT_EQ(Tokens(), (std::vector<std::string>{"", "p2"}));
}

TEST_F(UnfinishedStep, OfADeltaThatIsGoneComesAgain) {
  MapMirror& mirror = harness_.Start({Cut(Join({WholeFirst(), delta_})),
                                      Stay(Join({Created(first_), delta_, Progress(6, "t6")}))});
  ASSERT_TRUE(mirror.AwaitRevision(Revision(6), kHangTimeout).ok());
  EXPECT_EQ(ContentOf(*mirror.snapshot()), ContentOf(second_));
  harness_.AwaitEvents(2);
  EXPECT_EQ(harness_.event_numbers(), (std::vector<std::uint64_t>{1, 2}));
}

TEST_F(UnfinishedStep, OfAResyncGoesOn) {
  const Messages resync = WithTokens(SnapshotOf(second_, 5));
  MapMirror& mirror =
      harness_.Start({Cut(WholeFirst()),
                      Cut(Join({Created(first_), Resync(6), Head(resync, 2)})),
                      Stay(Join({Continued(second_), Tail(resync, 2), Progress(6, "t6")}))});
  ASSERT_TRUE(mirror.AwaitRevision(Revision(6), kHangTimeout).ok());
  EXPECT_EQ(ContentOf(*mirror.snapshot()), ContentOf(second_));
  harness_.AwaitResync();
  EXPECT_EQ(Tokens(), (std::vector<std::string>{"", "t5", "p2"}));
}

TEST_F(UnfinishedStep, ThatTheServerCannotFinishIsAskedForFromItsBeginning) {
  MapMirror& mirror =
      harness_.Start({Cut(Join({WholeFirst(), Head(delta_, 2)})),
                      [&](ScriptedWatch& watch) {
                        watch.Send(Continued(first_));
                        return WatchFailure(absl::StatusCode::kAborted, reason::kSlowConsumer);
                      },
                      Stay(Join({Created(first_), delta_, Progress(6, "t6")}))});
  ASSERT_TRUE(mirror.AwaitRevision(Revision(6), kHangTimeout).ok());
  EXPECT_EQ(ContentOf(*mirror.snapshot()), ContentOf(second_));
  EXPECT_EQ(Tokens(), (std::vector<std::string>{"", "p2", "t5"}));
}

struct WrongContinuation {
  const char* name;
  Messages first;
  Messages second;
  const char* message;
};

class HostileContinuation : public ::testing::TestWithParam<WrongContinuation> {};

TEST_P(HostileContinuation, IsNoticedAndFollowedByAFreshSnapshot) {
  MirrorHarness harness;
  const auto cut = [](const Messages& messages) {
    return [messages](ScriptedWatch& watch) {
      watch.Send(messages);
      return WatchFailure(absl::StatusCode::kUnavailable);
    };
  };
  MapMirror& mirror = harness.Start(
      {cut(GetParam().first), cut(GetParam().second), [](ScriptedWatch& watch) {
         watch.Send(Join({Created(SecondMap()), SnapshotOf(SecondMap()), Progress(6, "t6")}));
         return watch.Hold();
       }});
  ASSERT_TRUE(mirror.AwaitRevision(Revision(6), kHangTimeout).ok());
  EXPECT_EQ(ContentOf(*mirror.snapshot()), ContentOf(SecondMap()));
  EXPECT_EQ(harness.service.requests().at(2).start(), v1::WATCH_START_SNAPSHOT_THEN_FOLLOW);
  const std::vector<WatchStateChange> retries = harness.Changes(WatchState::kReconnecting);
  ASSERT_EQ(retries.size(), 2U);
  EXPECT_NE(retries[1].status.message().find(GetParam().message), std::string_view::npos)
      << retries[1].status;
}

std::vector<WrongContinuation> WrongContinuations() {
  const Messages parts = WithTokens(SnapshotOf(FirstMap(), 5));
  const Messages whole = Join({Created(FirstMap()), SnapshotOf(FirstMap()), Progress(5, "t5")});
  Messages long_token = Join({Created(FirstMap()), Head(parts, 1)});
  long_token[1].mutable_snapshot()->set_resume_token(std::string(257, 't'));
  const Messages begun = Join({Created(FirstMap()), Head(parts, 1)});
  Messages other = Continued(FirstMap());
  other[0].mutable_created()->set_incarnation("another");
  return {{"OfNothing", whole, Continued(FirstMap()), "none is unfinished"},
          {"OfAnotherRevision", begun, Continued(SecondMap()), "continues another step"},
          {"OfAnotherMap", begun, other, "continues another step"},
          {"WithATokenThatIsTooLong", Messages(), long_token, "a resume token of 257 bytes"}};
}

INSTANTIATE_TEST_SUITE_P(Servers,
                         HostileContinuation,
                         ::testing::ValuesIn(WrongContinuations()),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace steadymap
