// Tests a mirror against servers that violate the protocol of a watch.

#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/client/map/mirror_harness.h"

namespace steadymap {
namespace {

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

Messages WholeFirst() {
  return Join({Created(FirstMap()), SnapshotOf(FirstMap()), Progress(5, "t5")});
}

/// Returns the step from the first map to the second one, modified by `alter`.
Messages AlteredDelta(std::uint32_t fragments, const std::function<void(Messages*)>& alter) {
  Messages delta = DeltaOf(FirstMap(), SecondMap(), fragments);
  alter(&delta);
  return Join({WholeFirst(), delta, Progress(6, "t6")});
}

Messages AlteredLeaf(const std::function<void(v1::PackedLeaf*)>& alter) {
  return AlteredDelta(
      1, [&](Messages* delta) { alter((*delta)[0].mutable_delta()->mutable_leaves(0)); });
}

Messages AfterFirst(const Messages& messages) { return Join({WholeFirst(), messages}); }

struct HostileCase {
  const char* name;
  Messages messages;
  absl::StatusCode code = absl::StatusCode::kInternal;
  const char* message;
};

std::vector<HostileCase> BrokenOrder() {
  const auto internal = absl::StatusCode::kInternal;
  return {
      {"NoCreated", Progress(5, "t5"), internal, "`created` must come first"},
      {"CreatedTwice", AfterFirst(Created(FirstMap())), internal, "`created` must come first"},
      {"SnapshotUnasked", AfterFirst(SnapshotOf(FirstMap())), internal, "neither requested"},
      {"DeltaWithinSnapshot",
       Join({Created(FirstMap()), DeltaOf(FirstMap(), SecondMap())}),
       internal,
       "within a snapshot"},
      {"SnapshotOfTwoRevisions",
       Join({Created(FirstMap()), SnapshotOf(SecondMap())}),
       internal,
       "is of revision 6"},
      {"SnapshotEndsElsewhere",
       Join({Created(FirstMap()), SnapshotOf(FirstMap()), Progress(6, "t6")}),
       internal,
       "ended with the progress to revision 6"},
  };
}

std::vector<HostileCase> BrokenDeltas() {
  const auto internal = absl::StatusCode::kInternal;
  Messages repeated = DeltaOf(FirstMap(), SecondMap(), 2);
  repeated[1] = repeated[0];
  return {
      {"FragmentLeftOut",
       AlteredDelta(3, [](Messages* delta) { delta->erase(delta->begin() + 1); }),
       internal,
       "fragment 3 of 3 came after fragment 1 of 3"},
      {"FragmentTwice", AfterFirst(repeated), internal, "fragment 1 of 2 came after fragment 1"},
      {"FragmentMissing",
       AlteredDelta(3, [](Messages* delta) { delta->pop_back(); }),
       internal,
       "came after fragment 2 of 3"},
      {"FragmentCountChanges",
       AlteredDelta(3, [](Messages* delta) { (*delta)[1].mutable_delta()->set_fragments(4); }),
       internal,
       "fragment 2 of 4 came after fragment 1 of 3"},
      {"NoFragments",
       AlteredDelta(1, [](Messages* delta) { (*delta)[0].mutable_delta()->set_fragments(0); }),
       internal,
       "fragment 1 of 0"},
      {"RevisionsMixed",
       AlteredDelta(2, [](Messages* delta) { (*delta)[1].mutable_delta()->set_revision(7); }),
       internal,
       "within the step to revision 6"},
      {"GapBefore",
       AlteredDelta(1,
                    [](Messages* delta) { (*delta)[0].mutable_delta()->set_previous_revision(4); }),
       internal,
       "continues revision 4, but the watcher has revision 5"},
      {"RevisionFalls",
       AlteredDelta(1, [](Messages* delta) { (*delta)[0].mutable_delta()->set_revision(5); }),
       internal,
       "of revision 5 came after revision 5"},
  };
}

std::vector<HostileCase> BrokenEvents() {
  const auto internal = absl::StatusCode::kInternal;
  return {
      {"ProgressFalls",
       AfterFirst(Progress(4, "t4")),
       internal,
       "revision 4 came after revision 5"},
      {"ProgressOfAnotherRevision",
       AfterFirst(Join({Events(6, {1}), Progress(7, "t7")})),
       internal,
       "within the step to revision 6"},
      {"NoToken", AfterFirst(Progress(6, "")), internal, "a resume token of 0 bytes"},
      {"LongToken", AfterFirst(Progress(6, std::string(257, 't'))), internal, "257 bytes"},
      {"EventTwice", AfterFirst(Events(6, {4, 4})), internal, "event 4 came after event 4"},
      {"EventOfAnEarlierStep",
       AfterFirst(Join({Events(6, {4}), Progress(6, "t6"), Events(7, {4})})),
       internal,
       "event 4 came after event 4"},
      {"MessageAfterGoodbye",
       AfterFirst(Join({Goodbye(0), Progress(6, "t6")})),
       internal,
       "after the goodbye"},
  };
}

std::vector<HostileCase> BrokenLeaves() {
  const auto internal = absl::StatusCode::kInternal;
  const auto data_loss = absl::StatusCode::kDataLoss;
  return {
      {"DamagedLeaf",
       AlteredLeaf([](v1::PackedLeaf* leaf) { leaf->set_packed("garbage"); }),
       data_loss,
       "corrupt"},
      {"PatchOfALeafThatIsNotThere",
       AlteredDelta(1,
                    [](Messages* delta) {
                      v1::DeltaFragment& fragment = *(*delta)[0].mutable_delta();
                      fragment.mutable_leaves(fragment.leaves_size() - 1)->set_is_patch(true);
                    }),
       data_loss,
       "a patch of a leaf of object 3 that does not exist"},
      {"PatchWithoutVoxels",
       AlteredLeaf([](v1::PackedLeaf* leaf) {
         leaf->set_is_patch(true);
         leaf->clear_packed();
       }),
       data_loss,
       "a patch without voxels"},
      {"DamagedPatch",
       AlteredLeaf([](v1::PackedLeaf* leaf) {
         leaf->set_is_patch(true);
         leaf->set_packed("garbage");
       }),
       data_loss,
       "corrupt"},
      {"LeafBetweenLeaves",
       AlteredLeaf([](v1::PackedLeaf* leaf) { leaf->set_origin_y(3); }),
       internal,
       "not a multiple of 8"},
      {"LeafOfNoObject",
       AlteredDelta(1,
                    [](Messages* delta) {
                      v1::DeltaFragment& fragment = *(*delta)[0].mutable_delta();
                      fragment.mutable_leaves(fragment.leaves_size() - 1)->set_object_id(99);
                    }),
       data_loss,
       "object 99, which does not exist"},
      {"LeafOfARemovedObject",
       AlteredDelta(1, [](Messages* delta) { (*delta)[0].mutable_delta()->clear_objects(); }),
       data_loss,
       "object 3, which does not exist"},
  };
}

std::vector<HostileCase> BrokenContent() {
  const auto internal = absl::StatusCode::kInternal;
  Messages no_voxels = Created(FirstMap());
  no_voxels[0].mutable_created()->set_voxel_size_m(-0.05);
  Messages future_event = Events(6, {1});
  future_event[0].mutable_events()->mutable_events(0)->set_revision(7);
  Messages odd_progress = Progress(6, "t6");
  odd_progress[0].mutable_progress()->mutable_last_capture_time()->set_seconds(-1);
  Messages odd_event = Events(6, {1});
  odd_event[0].mutable_events()->mutable_events(0)->clear_type();
  return {
      {"NoVoxelSize", no_voxels, internal, "invalid voxel size"},
      {"OddObject",
       AlteredDelta(1,
                    [](Messages* delta) {
                      (*delta)[0].mutable_delta()->mutable_objects(0)->clear_belief();
                    }),
       internal,
       "invalid object with number 2"},
      {"OddCaptureTime", AfterFirst(odd_progress), internal, "invalid capture time"},
      {"EventOfTheFuture", AfterFirst(future_event), internal, "an event of revision 7"},
      {"OddEvent", AfterFirst(odd_event), internal, "invalid event with number 1"},
  };
}

class HostileWatch : public ::testing::TestWithParam<HostileCase> {};

TEST_P(HostileWatch, ShowsNothingOfItAndTakesAFreshSnapshot) {
  MapSnapshot fresh = SecondMap();
  fresh.revision = Revision(8);
  MirrorHarness harness;
  MapMirror& mirror =
      harness.Start({[&](ScriptedWatch& watch) {
                       watch.Send(GetParam().messages);
                       return watch.Hold();
                     },
                     [&](ScriptedWatch& watch) {
                       watch.Send(Join({Created(fresh), SnapshotOf(fresh), Progress(8, "t8")}));
                       return watch.Hold();
                     }});
  ASSERT_TRUE(mirror.AwaitRevision(Revision(8), kHangTimeout).ok());
  harness.AwaitResync();
  const absl::Status status = harness.Changes(WatchState::kResynced)[0].status;
  EXPECT_EQ(status.code(), GetParam().code) << status;
  EXPECT_NE(std::string(status.message()).find(GetParam().message), std::string::npos) << status;
  EXPECT_EQ(harness.service.requests().at(1).start(), v1::WATCH_START_SNAPSHOT_THEN_FOLLOW);
  EXPECT_EQ(watching::ContentOf(*mirror.snapshot()), watching::ContentOf(fresh));
  for (const MirrorStep& step : harness.steps()) {
    EXPECT_TRUE(step.map->revision == Revision(8) || step.map->revision == Revision(5) ||
                std::string(GetParam().name) == "EventOfAnEarlierStep")
        << step.map->revision.value();
  }
}

TEST_P(HostileWatch, EndsTheMirrorThatTakesNoResync) {
  MirrorHarness harness;
  harness.options.resync_if_compacted = false;
  harness.Start({[&](ScriptedWatch& watch) {
    watch.Send(GetParam().messages);
    return watch.Hold();
  }});
  EXPECT_EQ(harness.AwaitEnd().code(), GetParam().code);
  EXPECT_EQ(harness.service.requests().size(), 1U);
}

const auto kCaseName = [](const ::testing::TestParamInfo<HostileCase>& info) {
  return std::string(info.param.name);
};

INSTANTIATE_TEST_SUITE_P(Order, HostileWatch, ::testing::ValuesIn(BrokenOrder()), kCaseName);
INSTANTIATE_TEST_SUITE_P(Deltas, HostileWatch, ::testing::ValuesIn(BrokenDeltas()), kCaseName);
INSTANTIATE_TEST_SUITE_P(Events, HostileWatch, ::testing::ValuesIn(BrokenEvents()), kCaseName);
INSTANTIATE_TEST_SUITE_P(Leaves, HostileWatch, ::testing::ValuesIn(BrokenLeaves()), kCaseName);
INSTANTIATE_TEST_SUITE_P(Content, HostileWatch, ::testing::ValuesIn(BrokenContent()), kCaseName);

// A resumed stream must continue from the watcher's own revision and map.
class HostileResumption : public ::testing::TestWithParam<const char*> {};

TEST_P(HostileResumption, OfAnotherMapIsNoticedBeforeAnyStep) {
  MapSnapshot other = FirstMap();
  std::string incarnation = "first";
  if (std::string(GetParam()) == "revision") other.revision = Revision(4);
  if (std::string(GetParam()) == "incarnation") incarnation = "second";
  if (std::string(GetParam()) == "scale") other.scale.truncation_m = 0.2;
  MirrorHarness harness;
  MapMirror& mirror = harness.Start(
      {[&](ScriptedWatch& watch) {
         watch.Send(WholeFirst());
         return WatchFailure(absl::StatusCode::kUnavailable);
       },
       [&](ScriptedWatch& watch) {
         watch.Send(Join({Created(other, incarnation), Progress(6, "t6")}));
         return watch.Hold();
       },
       [&](ScriptedWatch& watch) {
         watch.Send(Join({Created(SecondMap()), SnapshotOf(SecondMap()), Progress(6, "t6")}));
         return watch.Hold();
       }});
  ASSERT_TRUE(mirror.AwaitRevision(Revision(6), kHangTimeout).ok());
  harness.AwaitResync();
  EXPECT_EQ(harness.Changes(WatchState::kResynced)[0].status.code(), absl::StatusCode::kInternal);
  EXPECT_EQ(watching::ContentOf(*mirror.snapshot()), watching::ContentOf(SecondMap()));
}

INSTANTIATE_TEST_SUITE_P(Created,
                         HostileResumption,
                         ::testing::Values("revision", "incarnation", "scale"));

TEST(HostileWatchServer, AnUnwantedResyncEndsTheMirror) {
  MirrorHarness harness;
  harness.options.resync_if_compacted = false;
  harness.Start({[&](ScriptedWatch& watch) {
    watch.Send(AfterFirst(Resync(9)));
    return watch.Hold();
  }});
  EXPECT_EQ(harness.AwaitEnd().code(), absl::StatusCode::kInternal);
  EXPECT_EQ(harness.mirror().revision(), Revision(5));
}

TEST(HostileWatchServer, KindsOfANewerServerArePassedOver) {
  MirrorHarness harness;
  MapMirror& mirror = harness.Start({[&](ScriptedWatch& watch) {
    watch.Send(Join({WholeFirst(), Messages(1), Progress(6, "t6")}));
    return watch.Hold();
  }});
  EXPECT_TRUE(mirror.AwaitRevision(Revision(6), kHangTimeout).ok());
  EXPECT_TRUE(harness.Changes(WatchState::kReconnecting).empty());
}

}  // namespace
}  // namespace steadymap
