#include "client/map/map_mirror.h"

#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/query/vdb_file.h"
#include "core/volume/tsdf_codec.h"
#include "proto/convert_object.h"
#include "proto/convert_watch.h"
#include "tests/client/map/mirror_harness.h"
#include "tests/support/deadline.h"

namespace steadymap {
namespace {

using watching::ContentOf;
using watching::Created;
using watching::DeltaOf;
using watching::Events;
using watching::FirstMap;
using watching::Goodbye;
using watching::Join;
using watching::Messages;
using watching::Progress;
using watching::Resync;
using watching::SecondMap;
using watching::SnapshotOf;

class MapMirrorTest : public ::testing::Test {
 protected:
  /// Returns a complete snapshot of the first map.
  Messages First() const { return Join({Created(first_), SnapshotOf(first_), Progress(5, "t5")}); }

  /// Returns the step to the second map.
  Messages Second(std::uint32_t fragments = 1) const {
    return Join({DeltaOf(first_, second_, fragments), Events(6, {1, 2}), Progress(6, "t6")});
  }

  const MapSnapshot first_ = FirstMap();
  const MapSnapshot second_ = SecondMap();
  MirrorHarness harness_;
};

TEST_F(MapMirrorTest, ShowsAnEmptyMapBeforeTheFirstWord) {
  MapMirror& mirror = harness_.Start({});
  EXPECT_EQ(mirror.revision(), Revision(0));
  EXPECT_EQ(mirror.snapshot()->background.leaf_count(), 0U);
  EXPECT_EQ(mirror.resume_token(), "");
  EXPECT_TRUE(mirror.status().ok());
  EXPECT_EQ(mirror.AwaitRevision(Revision(1), std::chrono::milliseconds(0)).code(),
            absl::StatusCode::kDeadlineExceeded);
}

TEST_F(MapMirrorTest, ASnapshotIsTheServersMapBitForBit) {
  harness_.options.filter.boxes_world = {
      Box(Eigen::Vector3d(-1.0, -2.0, -3.0), Eigen::Vector3d(4.0, 5.0, 6.0))};
  harness_.options.max_message_bytes = 70'000;
  MapMirror& mirror = harness_.Start({[&](ScriptedWatch& watch) {
    watch.Send(First());
    return watch.Hold();
  }});
  ASSERT_TRUE(mirror.AwaitRevision(Revision(5), kHangTimeout).ok());
  EXPECT_EQ(mirror.resume_token(), "t5");
  EXPECT_EQ(ContentOf(*mirror.snapshot()), ContentOf(first_));
  EXPECT_EQ(*WriteVdb(*mirror.snapshot(), nullptr), *WriteVdb(first_, nullptr));

  const v1::WatchMapRequest request = harness_.service.requests().at(0);
  EXPECT_EQ(request.map(), "tenants/default/maps/kitchen");
  EXPECT_EQ(request.start(), v1::WATCH_START_SNAPSHOT_THEN_FOLLOW);
  EXPECT_EQ(request.resume_token(), "");
  EXPECT_EQ(request.filter().SerializeAsString(),
            ToProto(harness_.options.filter).SerializeAsString());
  EXPECT_EQ(request.max_message_bytes(), 70'000U);
  EXPECT_TRUE(request.resync_if_compacted());
  EXPECT_TRUE(request.takes_patches());
}

TEST_F(MapMirrorTest, AStepTellsWhatChanged) {
  MapMirror& mirror = harness_.Start({[&](ScriptedWatch& watch) {
    watch.Send(Join({First(), Second(3)}));
    return watch.Hold();
  }});
  ASSERT_TRUE(mirror.AwaitRevision(Revision(6), kHangTimeout).ok());
  EXPECT_EQ(ContentOf(*mirror.snapshot()), ContentOf(second_));
  EXPECT_EQ(mirror.snapshot()->last_capture_time, second_.last_capture_time);
  EXPECT_EQ(mirror.resume_token(), "t6");
  harness_.AwaitEvents(2);
  const std::vector<MirrorStep> steps = harness_.steps();
  ASSERT_EQ(steps.size(), 2U);
  EXPECT_TRUE(steps[0].is_snapshot);
  EXPECT_FALSE(steps[1].is_snapshot);
  EXPECT_EQ(steps[1].previous_revision, Revision(5));
  EXPECT_EQ(steps[1].commits, 1U);
  EXPECT_EQ(steps[1].resume_token, "t6");
  EXPECT_EQ(steps[1].objects, (std::vector{ObjectId(1), ObjectId(2), ObjectId(3)}));
  EXPECT_EQ(ContentOf(*steps[0].map), ContentOf(first_)) << "published maps never change";
  ASSERT_GE(steps[1].leaves.size(), 3U);
  EXPECT_EQ(steps[1].leaves[0], (LeafKey{kBackgroundId, {0, 0, 0}}));
  EXPECT_EQ(steps[1].leaves[1], (LeafKey{kBackgroundId, {0, 0, 64}}));
  EXPECT_EQ(steps[1].leaves[2].object, ObjectId(3)) << "object 1 is gone with all its leaves";
  EXPECT_EQ(steps[1].events.size(), 2U);
  EXPECT_EQ(harness_.event_numbers(), (std::vector<std::uint64_t>{1, 2}));
}

TEST_F(MapMirrorTest, AStepThatIsCutInTheMiddleIsNeverSeenAndComesAgain) {
  const Messages cut = Join({First(), Events(6, {1}), {DeltaOf(first_, second_, 3)[0]}});
  watching::MapContent between;
  MapMirror& mirror = harness_.Start({[&](ScriptedWatch& watch) {
                                        watch.Send(cut);
                                        return WatchFailure(absl::StatusCode::kUnavailable);
                                      },
                                      [&](ScriptedWatch& watch) {
                                        between = ContentOf(*harness_.mirror().snapshot());
                                        watch.Send(Join({Created(first_), Second(2)}));
                                        return watch.Hold();
                                      }});
  ASSERT_TRUE(mirror.AwaitRevision(Revision(6), kHangTimeout).ok());
  EXPECT_EQ(between, ContentOf(first_));
  EXPECT_EQ(ContentOf(*mirror.snapshot()), ContentOf(second_));
  harness_.AwaitEvents(2);
  EXPECT_EQ(harness_.event_numbers(), (std::vector<std::uint64_t>{1, 2})) << "none twice";
  EXPECT_EQ(harness_.steps().size(), 2U);
  const v1::WatchMapRequest request = harness_.service.requests().at(1);
  EXPECT_EQ(request.resume_token(), "t5");
  EXPECT_EQ(request.start(), v1::WATCH_START_UNSPECIFIED);
  EXPECT_EQ(harness_.Changes(WatchState::kReconnecting).size(), 1U);
  EXPECT_TRUE(harness_.Changes(WatchState::kResynced).empty());
}

TEST_F(MapMirrorTest, ProgressAloneMovesTheRevisionAndTheToken) {
  MapMirror& mirror = harness_.Start({[&](ScriptedWatch& watch) {
    watch.Send(Join({First(), Progress(5, "t5 again"), Progress(8, "t8")}));
    return watch.Hold();
  }});
  ASSERT_TRUE(mirror.AwaitRevision(Revision(8), kHangTimeout).ok());
  EXPECT_EQ(mirror.resume_token(), "t8");
  watching::MapContent content = ContentOf(*mirror.snapshot());
  content.revision = 5;
  EXPECT_EQ(content, ContentOf(first_));
}

TEST_F(MapMirrorTest, AnObjectThatIsRemovedAndSentAgainIsReplacedWhole) {
  Messages delta = DeltaOf(first_, second_, 2);
  for (v1::WatchMapResponse& message : delta) {
    message.mutable_delta()->clear_removed_object_ids();
    message.mutable_delta()->clear_objects();
    message.mutable_delta()->clear_leaves();
  }
  // Removes both; object 1 returns in the next fragment with one of its leaves.
  delta[0].mutable_delta()->add_removed_object_ids(1);
  delta[0].mutable_delta()->add_removed_object_ids(2);
  delta[0].mutable_delta()->add_removed_object_ids(77);
  const MapObject& object = *first_.objects.at(ObjectId(1));
  *delta[1].mutable_delta()->add_objects() = ToProto(object);
  const watching::MapContent content = ContentOf(first_);
  const auto leaf = content.leaves.upper_bound({ObjectId(1), {-1000, 0, 0}});
  v1::PackedLeaf& sent = *delta[1].mutable_delta()->add_leaves();
  sent.set_object_id(1);
  sent.set_packed(leaf->second);
  MapMirror& mirror = harness_.Start({[&](ScriptedWatch& watch) {
    watch.Send(Join({First(), delta, Progress(6, "t6")}));
    return watch.Hold();
  }});
  ASSERT_TRUE(mirror.AwaitRevision(Revision(6), kHangTimeout).ok());
  const std::vector<std::shared_ptr<const MapObject>> objects = mirror.Objects();
  ASSERT_EQ(objects.size(), 1U);
  EXPECT_EQ(objects[0]->id, ObjectId(1));
  EXPECT_EQ(objects[0]->volume->leaf_count(), 1U);
  EXPECT_TRUE(objects[0]->volume->FindLeaf({0, 0, 0}));
}

TEST_F(MapMirrorTest, AfterAResyncTheOldMapStaysUntilTheNewOneIsWhole) {
  MapSnapshot newest = second_;
  newest.revision = Revision(9);
  const Messages resync = Join({Created(first_), Resync(9)});
  watching::MapContent between;
  MapMirror& mirror =
      harness_.Start({[&](ScriptedWatch& watch) {
                        watch.Send(Join({First(), {DeltaOf(first_, second_)[0]}}));
                        return grpc::Status::OK;
                      },
                      [&](ScriptedWatch& watch) {
                        watch.Send(Join({resync, {SnapshotOf(newest, 5)[0]}}));
                        return WatchFailure(absl::StatusCode::kUnavailable);
                      },
                      [&](ScriptedWatch& watch) {
                        between = ContentOf(*harness_.mirror().snapshot());
                        watch.Send(Join({resync, SnapshotOf(newest), Progress(9, "t9")}));
                        return watch.Hold();
                      }});
  ASSERT_TRUE(mirror.AwaitRevision(Revision(9), kHangTimeout).ok());
  EXPECT_EQ(between, ContentOf(first_));
  EXPECT_EQ(ContentOf(*mirror.snapshot()), ContentOf(newest));
  EXPECT_EQ(harness_.service.requests().at(2).resume_token(), "t5");
  harness_.AwaitResync();
  const std::vector<WatchStateChange> resyncs = harness_.Changes(WatchState::kResynced);
  ASSERT_EQ(resyncs.size(), 1U);
  EXPECT_EQ(ReasonOf(resyncs[0].status), reason::kRevisionCompacted);
  EXPECT_TRUE(harness_.steps().back().is_snapshot);
}

TEST_F(MapMirrorTest, AGoodbyeIsWaitedForAndThenResumed) {
  MapMirror& mirror =
      harness_.Start({[&](ScriptedWatch& watch) {
                        watch.Send(Join({First(), Goodbye(40)}));
                        return WatchFailure(absl::StatusCode::kUnavailable, reason::kDraining);
                      },
                      [&](ScriptedWatch& watch) {
                        watch.Send(Join({Created(first_), Second()}));
                        return watch.Hold();
                      }});
  ASSERT_TRUE(mirror.AwaitRevision(Revision(6), kHangTimeout).ok());
  const std::vector<WatchStateChange> waits = harness_.Changes(WatchState::kReconnecting);
  ASSERT_EQ(waits.size(), 1U);
  EXPECT_GE(waits[0].delay, std::chrono::seconds(40));
  EXPECT_EQ(ReasonOf(waits[0].status), reason::kDraining);
  EXPECT_EQ(harness_.service.requests().at(1).resume_token(), "t5");
}

TEST_F(MapMirrorTest, WhatHealsIsResumedAndWaitsGrow) {
  std::vector<FakeWatchService::Script> scripts = {[&](ScriptedWatch& watch) {
    watch.Send(First());
    return WatchFailure(absl::StatusCode::kAborted, reason::kSlowConsumer);
  }};
  for (const absl::StatusCode code : {absl::StatusCode::kDeadlineExceeded,
                                      absl::StatusCode::kUnavailable,
                                      absl::StatusCode::kResourceExhausted,
                                      absl::StatusCode::kInternal}) {
    scripts.emplace_back([code](ScriptedWatch&) { return WatchFailure(code); });
  }
  scripts.emplace_back([&](ScriptedWatch& watch) {
    watch.Send(Join({Created(first_), Second()}));
    return watch.Hold();
  });
  harness_.options.backoff.jitter = 0.0;
  MapMirror& mirror = harness_.Start(scripts);
  ASSERT_TRUE(mirror.AwaitRevision(Revision(6), kHangTimeout).ok());
  std::vector<std::int64_t> delays_ms;
  for (const WatchStateChange& change : harness_.Changes(WatchState::kReconnecting)) {
    delays_ms.push_back(change.delay.count());
  }
  // At most half a second if no server answered.
  EXPECT_EQ(delays_ms, (std::vector<std::int64_t>{100, 200, 400, 500, 500}));
  for (std::size_t i = 1; i < 6; ++i) {
    EXPECT_EQ(harness_.service.requests().at(i).resume_token(), "t5");
  }
}

TEST_F(MapMirrorTest, AMirrorFromNowOnHoldsWhatChanges) {
  harness_.options.start = WatchOpening::kNow;
  MapMirror& mirror = harness_.Start({[&](ScriptedWatch& watch) {
    watch.Send(Join({Created(first_), Second()}));
    return watch.Hold();
  }});
  ASSERT_TRUE(mirror.AwaitRevision(Revision(6), kHangTimeout).ok());
  EXPECT_EQ(harness_.service.requests().at(0).start(), v1::WATCH_START_NOW);
  EXPECT_FALSE(harness_.service.requests().at(0).takes_patches()) << "there are no leaves to patch";
  const watching::MapContent content = ContentOf(*mirror.snapshot());
  EXPECT_EQ(content.objects.size(), 2U);
  EXPECT_EQ(content.objects.at(3), ContentOf(second_).objects.at(3));
}

TEST_F(MapMirrorTest, WhatIsMissedBetweenTwoBeginningsIsSaid) {
  harness_.options.start = WatchOpening::kNow;
  MapMirror& mirror = harness_.Start({[&](ScriptedWatch& watch) {
                                        watch.Send(Created(first_));
                                        return WatchFailure(absl::StatusCode::kUnavailable);
                                      },
                                      [&](ScriptedWatch& watch) {
                                        watch.Send(Created(second_));
                                        return watch.Hold();
                                      }});
  harness_.AwaitResync();
  EXPECT_EQ(mirror.revision(), Revision(6));
  EXPECT_NE(harness_.Changes(WatchState::kResynced)[0].status.message().find("since revision 5"),
            absl::string_view::npos);
}

TEST_F(MapMirrorTest, AGivenTokenIsResumedFrom) {
  harness_.options.start = WatchOpening::kResume;
  harness_.options.resume_token = "kept";
  MapMirror& mirror = harness_.Start({[&](ScriptedWatch& watch) {
                                        watch.Send(Created(first_));
                                        return WatchFailure(absl::StatusCode::kUnavailable);
                                      },
                                      [&](ScriptedWatch& watch) {
                                        watch.Send(Join({Created(first_), Second()}));
                                        return watch.Hold();
                                      }});
  ASSERT_TRUE(mirror.AwaitRevision(Revision(6), kHangTimeout).ok());
  EXPECT_EQ(harness_.service.requests().at(0).resume_token(), "kept");
  EXPECT_EQ(harness_.service.requests().at(1).resume_token(), "kept");
}

TEST_F(MapMirrorTest, QueriesSeeTheMirroredMap) {
  MapMirror& mirror = harness_.Start({[&](ScriptedWatch& watch) {
    watch.Send(First());
    return watch.Hold();
  }});
  ASSERT_TRUE(mirror.AwaitRevision(Revision(5), kHangTimeout).ok());
  const std::vector<Eigen::Vector3d> points = {{1.5, -1.0, 0.05}, {0.0, 0.0, 9.0}};
  const std::vector<MapDistance> distances = mirror.SampleDistance(points);
  ASSERT_EQ(distances.size(), 2U);
  EXPECT_NEAR(distances[0].sample.distance_m, 0.05, 1e-3);
  EXPECT_FALSE(distances[1].sample.known);
  const std::vector<WorldRay> rays = {{{0.0, 0.5, 3.0}, {0.0, 0.0, -2.0}},
                                      {{0.0, 0.5, 3.0}, {0.0, 0.0, 0.0}}};
  const std::vector<MapRayHit> hits = mirror.CastRays(rays, 10.0);
  ASSERT_EQ(hits.size(), 2U);
  EXPECT_EQ(hits[0].object, ObjectId(2));
  EXPECT_NEAR(hits[0].hit.range_m, 2.3, 1e-3);
  EXPECT_FALSE(hits[1].hit.hit);
}

TEST_F(MapMirrorTest, StopsWhileNothingArrives) {
  absl::Notification watching;
  auto harness = std::make_unique<MirrorHarness>();
  harness->Start({[&](ScriptedWatch& watch) {
    watch.Send(Created(first_));
    watching.Notify();
    return watch.Hold();
  }});
  ASSERT_TRUE(watching.WaitForNotificationWithTimeout(absl::FromChrono(kHangTimeout)));
  testing::RunWithDeadline("stopping a mirror", [&] { harness.reset(); });
}

TEST_F(MapMirrorTest, StopsWhileItWaitsForTheNextTry) {
  absl::Notification waiting;
  FakeWatchService service(
      {[](ScriptedWatch&) { return WatchFailure(absl::StatusCode::kUnavailable); }});
  const FakeServer server(&service);
  MirrorCallbacks callbacks;
  int retries = 0;
  callbacks.on_state = [&](const WatchStateChange&) {
    if (++retries == 1) waiting.Notify();
  };
  MirrorOptions options;
  options.backoff.first_delay = std::chrono::hours(1);
  options.backoff.max_delay = std::chrono::hours(1);
  std::unique_ptr<MapMirror> mirror =
      MapMirror::Start(server.channels(), {"default", "kitchen"}, options, callbacks);
  ASSERT_TRUE(waiting.WaitForNotificationWithTimeout(absl::FromChrono(kHangTimeout)));
  testing::RunWithDeadline("stopping a mirror", [&] { mirror.reset(); });
  EXPECT_EQ(retries, 1) << "it stopped while it waited, and did not try again";
  service.Release();
}

TEST_F(MapMirrorTest, GivesUpWhenToldSo) {
  std::vector<FakeWatchService::Script> scripts(
      20, [](ScriptedWatch&) { return WatchFailure(absl::StatusCode::kUnavailable); });
  harness_.options.backoff.give_up_after = std::chrono::seconds(2);
  MapMirror& mirror = harness_.Start(scripts);
  EXPECT_EQ(harness_.AwaitEnd().code(), absl::StatusCode::kUnavailable);
  EXPECT_LT(harness_.service.requests().size(), 10U);
  EXPECT_EQ(mirror.AwaitRevision(Revision(1), kHangTimeout).code(), absl::StatusCode::kUnavailable);
}

TEST_F(MapMirrorTest, OptionsThatMakeNoSenseEndItBeforeItBegins) {
  {
    MirrorHarness harness;
    harness.options.filter.events = harness.options.filter.states = false;
    harness.options.filter.volumes = false;
    harness.Start({});
    EXPECT_EQ(harness.AwaitEnd().code(), absl::StatusCode::kInvalidArgument);
    EXPECT_TRUE(harness.service.requests().empty());
  }
  MirrorHarness harness;
  harness.options.start = WatchOpening::kResume;
  harness.Start({});
  EXPECT_EQ(harness.AwaitEnd().code(), absl::StatusCode::kInvalidArgument);
}

class FinalWatchStatus : public ::testing::TestWithParam<absl::Status> {};

TEST_P(FinalWatchStatus, EndsTheMirrorWithoutARetry) {
  MirrorHarness harness;
  harness.options.resync_if_compacted = false;
  harness.Start({[&](ScriptedWatch&) { return ToGrpcStatus(GetParam()); }});
  EXPECT_EQ(harness.AwaitEnd(), GetParam());
  EXPECT_EQ(harness.service.requests().size(), 1U);
  EXPECT_TRUE(harness.Changes(WatchState::kReconnecting).empty());
}

INSTANTIATE_TEST_SUITE_P(
    MapMirror,
    FinalWatchStatus,
    ::testing::Values(
        MakeError(absl::StatusCode::kNotFound, reason::kNotFound, "no such map"),
        MakeError(absl::StatusCode::kInvalidArgument, reason::kBadValue, "bad", "filter.boxes[0]"),
        MakeError(absl::StatusCode::kInvalidArgument, reason::kBadResumeToken, "not yours"),
        MakeError(absl::StatusCode::kOutOfRange, reason::kRevisionCompacted, "gone"),
        MakeError(absl::StatusCode::kDataLoss, reason::kChecksum, "the map is damaged"),
        MakeError(absl::StatusCode::kResourceExhausted, reason::kMessageTooLarge, "too large"),
        absl::PermissionDeniedError("not yours"),
        absl::UnimplementedError("an old server")));

class LostHistory : public MapMirrorTest, public ::testing::WithParamInterface<absl::Status> {};

TEST_P(LostHistory, IsMadeUpForByASnapshot) {
  MapMirror& mirror = harness_.Start(
      {[&](ScriptedWatch& watch) {
         watch.Send(First());
         return WatchFailure(absl::StatusCode::kUnavailable);
       },
       [&](ScriptedWatch&) { return ToGrpcStatus(GetParam()); },
       [&](ScriptedWatch& watch) {
         watch.Send(Join({Created(second_, "second"), SnapshotOf(second_), Progress(6, "t6")}));
         return watch.Hold();
       }});
  ASSERT_TRUE(mirror.AwaitRevision(Revision(6), kHangTimeout).ok());
  harness_.AwaitResync();
  EXPECT_EQ(harness_.Changes(WatchState::kResynced)[0].status, GetParam());
  EXPECT_EQ(harness_.service.requests().at(2).start(), v1::WATCH_START_SNAPSHOT_THEN_FOLLOW);
  EXPECT_EQ(harness_.service.requests().at(2).resume_token(), "");
  EXPECT_EQ(ContentOf(*mirror.snapshot()), ContentOf(second_));
}

INSTANTIATE_TEST_SUITE_P(
    MapMirror,
    LostHistory,
    ::testing::Values(
        MakeError(absl::StatusCode::kOutOfRange, reason::kRevisionCompacted, "gone"),
        MakeError(absl::StatusCode::kOutOfRange, reason::kRevisionInFuture, "not yet"),
        MakeError(absl::StatusCode::kInvalidArgument, reason::kBadResumeToken, "of another")));

}  // namespace
}  // namespace steadymap
