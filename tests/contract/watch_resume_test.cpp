// Tests resume tokens: their validity, and the errors of watches that cannot resume.

#include <cstdint>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/contract/watch_fixture.h"

namespace steadymap {
namespace {

using ::absl::StatusCode;
using ::testing::IsEmpty;

class WatchResumeTest : public WatchServiceTest {};

INSTANTIATE_TEST_SUITE_P(Transports,
                         WatchResumeTest,
                         ::testing::Values(Transport::kInProcess, Transport::kLoopback),
                         TransportName);

TEST_P(WatchResumeTest, ResumedBehindATokenMissesNothingAfterARestart) {
  Upload();
  ToldLeaves view;
  v1::WatchProgress progress;
  {
    const auto watch = Watch(Request());
    const auto begin = watch->ReadStep();
    ASSERT_TRUE(begin.has_value());
    view.Take(*begin);
    progress = begin->progress;
  }
  Upload();
  service_.Restart();
  const std::uint64_t target = Upload();
  const auto watch = Watch(ResumeBehind(progress));
  const auto step = watch->ReadUntil(target);
  ASSERT_TRUE(step.has_value());
  EXPECT_EQ(step->created->revision(), progress.revision());
  EXPECT_THAT(step->snapshot, IsEmpty());
  EXPECT_EQ(step->delta[0].previous_revision(), progress.revision());
  view.Take(*step);
  EXPECT_EQ(view.All(), LeavesByQuery());
}

TEST_P(WatchResumeTest, ResumedWhereNothingHappenedSinceItSaysSoAtOnce) {
  const std::uint64_t revision = Upload();
  const auto begin = Watch(Request())->ReadStep();
  ASSERT_TRUE(begin.has_value());
  v1::WatchProgress progress = begin->progress;
  for (int i = 0; i < 2; ++i) {
    const auto resumed = Watch(ResumeBehind(progress))->ReadStep();
    ASSERT_TRUE(resumed.has_value());
    EXPECT_THAT(resumed->delta, IsEmpty());
    EXPECT_THAT(resumed->events, IsEmpty());
    EXPECT_EQ(resumed->progress.revision(), revision);
    EXPECT_TRUE(resumed->progress.has_last_capture_time());
    progress = resumed->progress;
  }
  EXPECT_EQ(progress.resume_token(), begin->progress.resume_token());
}

TEST_P(WatchResumeTest, TokensAreGoodForTheirFilterAlone) {
  Upload();
  const auto begin = Watch(Request())->ReadStep();
  ASSERT_TRUE(begin.has_value());
  v1::WatchMapRequest request = ResumeBehind(begin->progress);
  request.mutable_filter()->set_include_archived(true);
  EXPECT_THAT(ErrorOf(request),
              IsError(StatusCode::kInvalidArgument, "BAD_RESUME_TOKEN", "filter"));
}

TEST_P(WatchResumeTest, AnotherFilterOrMapIsResyncedWhereAskedFor) {
  const std::string hall = map_;
  const std::uint64_t revision = Upload();
  const auto begin = Watch(Request())->ReadStep();
  ASSERT_TRUE(begin.has_value());
  v1::WatchMapRequest other_filter = ResumeBehind(begin->progress);
  other_filter.mutable_filter()->set_include_archived(true);
  map_ = service_.CreateMap("yard");
  const v1::WatchMapRequest other_map = ResumeBehind(begin->progress);
  EXPECT_THAT(ErrorOf(other_map),
              IsError(StatusCode::kInvalidArgument, "BAD_RESUME_TOKEN", "resume_token"));
  for (v1::WatchMapRequest request : {other_filter, other_map}) {
    request.set_resync_if_compacted(true);
    const auto step = Watch(request)->ReadStep();
    ASSERT_TRUE(step.has_value());
    ASSERT_TRUE(step->resync.has_value());
    EXPECT_EQ(step->resync->reason(), "BAD_RESUME_TOKEN");
    EXPECT_EQ(step->progress.revision(), request.map() == hall ? revision : 0);
  }
}

TEST_P(WatchResumeTest, FiltersAreComparedAsSets) {
  const std::uint64_t revision = Upload();
  v1::WatchMapRequest request = Request();
  request.mutable_filter()->add_class_ids(4);
  request.mutable_filter()->add_class_ids(7);
  request.mutable_filter()->add_object_ids(2);
  request.mutable_filter()->add_object_ids(1);
  const auto begin = Watch(request)->ReadStep();
  ASSERT_TRUE(begin.has_value());
  v1::WatchMapRequest same = ResumeBehind(begin->progress);
  for (const unsigned id : {7U, 4U, 7U}) same.mutable_filter()->add_class_ids(id);
  for (const unsigned id : {1U, 2U}) same.mutable_filter()->add_object_ids(id);
  for (const v1::WatchKind kind :
       {v1::WATCH_KIND_VOLUMES, v1::WATCH_KIND_EVENTS, v1::WATCH_KIND_OBJECTS}) {
    same.mutable_filter()->add_kinds(kind);
  }
  const auto created = Watch(same)->Read();
  ASSERT_TRUE(created.has_value());
  EXPECT_EQ(created->created().revision(), revision);
}

TEST_P(WatchResumeTest, ATokenOfAWatchFromNowOnHasNoLeavesToPatch) {
  Upload();
  const auto now = Watch(Request(v1::WATCH_START_NOW))->ReadStep();
  ASSERT_TRUE(now.has_value());
  v1::WatchMapRequest request = ResumeBehind(now->progress);
  request.set_takes_patches(true);
  const auto kRefused = IsError(StatusCode::kInvalidArgument, "BAD_VALUE", "takes_patches");
  EXPECT_THAT(ErrorOf(request), kRefused);
  // Steps do not contain older changes.
  const std::uint64_t target = Upload();
  const auto later = Watch(ResumeBehind(now->progress))->ReadUntil(target);
  ASSERT_TRUE(later.has_value());
  request.set_resume_token(later->progress.resume_token());
  EXPECT_THAT(ErrorOf(request), kRefused);
}

TEST_P(WatchResumeTest, ATokenBehindAResyncHasLeavesToPatch) {
  Upload();
  const auto now = Watch(Request(v1::WATCH_START_NOW))->ReadStep();
  ASSERT_TRUE(now.has_value());
  v1::WatchMapRequest resynced = ResumeBehind(now->progress);
  resynced.mutable_filter()->set_include_archived(true);
  resynced.set_resync_if_compacted(true);
  const auto snapshot = Watch(resynced)->ReadStep();
  ASSERT_TRUE(snapshot.has_value());
  ASSERT_TRUE(snapshot->resync.has_value());
  resynced.set_resume_token(snapshot->progress.resume_token());
  resynced.set_takes_patches(true);
  const auto created = Watch(resynced)->Read();
  ASSERT_TRUE(created.has_value());
  EXPECT_TRUE(created->has_created());
}

TEST_P(WatchResumeTest, BehindCompactionIsOutOfRangeOrASnapshotWhereAskedFor) {
  Upload();
  const auto begin = Watch(Request())->ReadStep();
  ASSERT_TRUE(begin.has_value());
  const std::uint64_t target = Upload();
  const MapRecord record = service_.store().ListMaps()->front();
  ASSERT_TRUE(service_.store().Trim(record, {.uptime = std::chrono::hours(1'000'000)}).ok());
  v1::WatchMapRequest request = ResumeBehind(begin->progress);
  EXPECT_THAT(ErrorOf(request), IsError(StatusCode::kOutOfRange, "REVISION_COMPACTED", ""));
  EXPECT_FALSE(Watch(request)->Read().has_value()) << "the watch must not start";
  request.set_resync_if_compacted(true);
  const auto step = Watch(request)->ReadUntil(target);
  ASSERT_TRUE(step.has_value());
  ASSERT_TRUE(step->resync.has_value());
  EXPECT_EQ(step->resync->reason(), "REVISION_COMPACTED");
  EXPECT_EQ(step->resync->revision(), target);
  ToldLeaves view;
  view.Take(*step);
  EXPECT_EQ(view.All(), LeavesByQuery());
}

TEST_P(WatchResumeTest, TokenOfAMapThatWasMadeAnewIsOutOfRange) {
  Upload();
  const auto begin = Watch(Request())->ReadStep();
  ASSERT_TRUE(begin.has_value());
  ASSERT_TRUE(service_.DeleteMap(map_).ok());
  EXPECT_EQ(service_.CreateMap("hall"), map_);
  v1::WatchMapRequest request = ResumeBehind(begin->progress);
  EXPECT_THAT(ErrorOf(request),
              IsError(StatusCode::kOutOfRange, "REVISION_COMPACTED", "resume_token"));
  request.set_resync_if_compacted(true);
  const auto step = Watch(request)->ReadStep();
  ASSERT_TRUE(step.has_value());
  EXPECT_TRUE(step->resync.has_value());
  EXPECT_EQ(step->progress.revision(), 0U);
}

}  // namespace
}  // namespace steadymap
