// Tests the messages of a watch, in process and over loopback.

#include <algorithm>
#include <cstdint>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/map/map_delta.h"
#include "tests/contract/object_map.h"
#include "tests/contract/test_service.h"
#include "tests/contract/watch_fixture.h"

namespace steadymap {
namespace {

using ::absl::StatusCode;
using ::testing::AllOf;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::Ge;
using ::testing::IsEmpty;
using ::testing::Le;
using ::testing::Property;
using ::testing::SizeIs;
using ::testing::UnorderedElementsAre;

INSTANTIATE_TEST_SUITE_P(Transports,
                         WatchServiceTest,
                         ::testing::Values(Transport::kInProcess, Transport::kLoopback),
                         TransportName);

std::vector<std::uint64_t> IdsOf(const std::vector<v1::Object>& objects) {
  std::vector<std::uint64_t> ids;
  ids.reserve(objects.size());
  for (const v1::Object& object : objects) ids.push_back(object.id());
  return ids;
}

std::vector<std::uint64_t> NumbersOf(const std::vector<v1::ObjectEvent>& events) {
  std::vector<std::uint64_t> numbers;
  numbers.reserve(events.size());
  for (const v1::ObjectEvent& event : events) numbers.push_back(event.number());
  return numbers;
}

TEST_P(WatchServiceTest, OfAnEmptyMapSaysSoAndGoesOnWithWhatHappens) {
  const auto watch = Watch(Request());
  const auto begin = watch->ReadStep();
  ASSERT_TRUE(begin.has_value());
  ASSERT_TRUE(begin->created.has_value());
  EXPECT_EQ(begin->created->revision(), 0U);
  EXPECT_EQ(begin->created->voxel_size_m(), 0.05);
  EXPECT_EQ(begin->created->truncation_m(), 0.15);
  EXPECT_FALSE(begin->created->incarnation().empty());
  EXPECT_EQ(begin->progress.revision(), 0U);
  EXPECT_THAT(begin->Leaves(), IsEmpty());
  const auto step = watch->ReadUntil(Upload());
  ASSERT_TRUE(step.has_value());
  ToldLeaves view;
  view.Take(*step);
  EXPECT_THAT(view.All(), SizeIs(Ge(1U)));
  EXPECT_EQ(view.All(), LeavesByQuery());
}

TEST_P(WatchServiceTest, SnapshotAndStepsAreTheMapBitForBit) {
  Upload();
  v1::WatchMapRequest request = Request();
  request.set_takes_patches(true);
  const auto watch = Watch(request);
  ToldLeaves view;
  auto step = watch->ReadStep();
  for (int i = 0; i < 4; ++i) {
    ASSERT_TRUE(step.has_value());
    view.Take(*step);
    EXPECT_EQ(view.All(), LeavesByQuery());
    step = watch->ReadUntil(Upload(3));
  }
  EXPECT_GT(view.patches(), 0U);
}

TEST_P(WatchServiceTest, FromNowTellsNothingOfBefore) {
  const std::uint64_t before = Upload();
  const auto watch = Watch(Request(v1::WATCH_START_NOW));
  const auto created = watch->Read();
  ASSERT_TRUE(created.has_value());
  EXPECT_EQ(created->created().revision(), before);
  const auto step = watch->ReadUntil(Upload());
  ASSERT_TRUE(step.has_value());
  EXPECT_THAT(step->snapshot, IsEmpty());
  ASSERT_THAT(step->delta, SizeIs(Ge(1U)));
  EXPECT_EQ(step->delta[0].previous_revision(), before);
}

TEST_P(WatchServiceTest, FromNowHasATokenFromTheFirst) {
  const std::uint64_t before = Upload();
  auto watch = Watch(Request(v1::WATCH_START_NOW));
  ASSERT_TRUE(watch->Read().has_value());
  Upload();
  const auto first = watch->ReadStep();
  ASSERT_TRUE(first.has_value());
  EXPECT_EQ(first->progress.revision(), before);
  EXPECT_TRUE(first->progress.has_last_capture_time());
  EXPECT_THAT(first->delta, IsEmpty());
  EXPECT_THAT(first->events, IsEmpty());
  watch.reset();
  const auto step = Watch(ResumeBehind(first->progress))->ReadStep();
  ASSERT_TRUE(step.has_value());
  ASSERT_THAT(step->delta, SizeIs(Ge(1U)));
  EXPECT_EQ(step->delta[0].previous_revision(), before);
}

TEST_P(WatchServiceTest, StepsNameTheRevisionsTheyLeadBetween) {
  const auto watch = Watch(Request());
  std::uint64_t reached = watch->ReadStep()->progress.revision();
  for (int i = 0; i < 5; ++i) {
    const std::uint64_t target = Upload(2);
    while (reached < target) {
      const auto step = watch->ReadStep();
      ASSERT_TRUE(step.has_value());
      ASSERT_THAT(step->delta, SizeIs(1));
      EXPECT_EQ(step->delta[0].previous_revision(), reached);
      EXPECT_EQ(step->delta[0].fragment(), 1U);
      EXPECT_EQ(step->delta[0].fragments(), 1U);
      EXPECT_GE(step->delta[0].commits(), 1U);
      EXPECT_GT(step->progress.revision(), reached);
      EXPECT_EQ(step->delta[0].revision(), step->progress.revision());
      EXPECT_TRUE(step->progress.has_last_capture_time());
      reached = step->progress.revision();
    }
  }
}

TEST_P(WatchServiceTest, ShowsPresentObjectsAndTheEventsThatCome) {
  StoreObjectMap(&service_);
  const auto watch = Watch(Request());
  const auto begin = watch->ReadStep();
  ASSERT_TRUE(begin.has_value());
  EXPECT_THAT(IdsOf(begin->Objects()), ElementsAre(1U, 3U));
  // Past events are available through ListEvents.
  EXPECT_THAT(begin->events, IsEmpty());
  ToldLeaves view;
  view.Take(*begin);
  EXPECT_EQ(view.All(), LeavesByQuery());
}

TEST_P(WatchServiceTest, FiltersByClassBoxObjectAndKind) {
  StoreObjectMap(&service_);
  const auto shown = [&](const v1::WatchFilter& filter) {
    v1::WatchMapRequest request = Request();
    *request.mutable_filter() = filter;
    const auto step = Watch(request)->ReadStep();
    EXPECT_TRUE(step.has_value());
    return step.value_or(ToldStep());
  };
  v1::WatchFilter filter;
  filter.add_class_ids(103);
  EXPECT_THAT(IdsOf(shown(filter).Objects()), ElementsAre(3U));
  EXPECT_THAT(shown(filter).Leaves(),
              AllOf(SizeIs(Ge(1U)), Each(Property(&v1::PackedLeaf::object_id, 3U))));
  filter.set_include_archived(true);
  filter.add_class_ids(102);
  EXPECT_THAT(IdsOf(shown(filter).Objects()), ElementsAre(2U, 3U));
  filter.add_object_ids(2);
  EXPECT_THAT(IdsOf(shown(filter).Objects()), ElementsAre(2U));
  filter.Clear();
  v1::Box* box = filter.add_boxes();
  box->mutable_min_m()->set_x(-0.6);
  box->mutable_min_m()->set_y(0.4);
  box->mutable_min_m()->set_z(0.7);
  box->mutable_max_m()->set_x(-0.4);
  box->mutable_max_m()->set_y(0.6);
  box->mutable_max_m()->set_z(0.9);
  EXPECT_THAT(IdsOf(shown(filter).Objects()), ElementsAre(1U));
  EXPECT_THAT(shown(filter).Leaves(), Each(Property(&v1::PackedLeaf::object_id, 1U)));
  filter.Clear();
  filter.add_kinds(v1::WATCH_KIND_OBJECTS);
  EXPECT_THAT(IdsOf(shown(filter).Objects()), ElementsAre(1U, 3U));
  EXPECT_THAT(shown(filter).Leaves(), IsEmpty());
  filter.Clear();
  filter.add_kinds(v1::WATCH_KIND_EVENTS);
  EXPECT_THAT(shown(filter).Objects(), IsEmpty());
}

TEST_P(WatchServiceTest, TellsEventsAndTombstonesOfWhatAStoppedServerMissed) {
  StoreObjectMap(&service_);
  const auto begin = Watch(Request())->ReadStep();
  ASSERT_TRUE(begin.has_value());
  // While no server runs: box 1 is archived, box 2 present again, box 3 removed.
  const MapKey key = service_.store().ListMaps()->front().key;
  MapSnapshot before = MakeObjectMap();
  MapSnapshot after = before;
  MapObject first = *before.objects.at(ObjectId(1));
  first.status = ObjectStatus::kArchived;
  MapObject second = *before.objects.at(ObjectId(2));
  second.status = ObjectStatus::kPresent;
  after.objects.insert_or_assign(first.id, std::make_shared<const MapObject>(first));
  after.objects.insert_or_assign(second.id, std::make_shared<const MapObject>(second));
  after.objects.erase(ObjectId(3));
  after.revision = Revision(kObjectMapRevision + 1);
  MapDelta delta = Diff(before, after);
  ObjectEvent event = MakeObjectHistory(before).back();
  event.revision = after.revision;
  event.object = ObjectId(1);
  delta.events = {event};
  LogAppend append{key, MapUptime(2), {}, {}};
  append.entries.emplace_back().sequence = MapSequence(kObjectMapRevision + 1);
  ASSERT_TRUE(service_.store().Append(append).ok());
  ASSERT_TRUE(service_.store().CommitRevision(key, delta, {.uptime = MapUptime(2)}).ok());
  service_.Restart();
  const auto step = Watch(ResumeBehind(begin->progress))->ReadStep();
  ASSERT_TRUE(step.has_value());
  EXPECT_EQ(step->progress.revision(), kObjectMapRevision + 1);
  EXPECT_THAT(step->Removed(), UnorderedElementsAre(1U, 2U, 3U));
  EXPECT_THAT(IdsOf(step->Objects()), ElementsAre(2U));
  EXPECT_THAT(
      step->Leaves(),
      AllOf(SizeIs(second.volume->leaf_count()), Each(Property(&v1::PackedLeaf::object_id, 2U))));
  EXPECT_THAT(NumbersOf(step->events), ElementsAre(6U));
}

TEST_P(WatchServiceTest, MessagesKeepToTheirLimitAndFragmentsAreCounted) {
  StoreObjectMap(&service_);
  v1::WatchMapRequest request = Request();
  request.set_max_message_bytes(65'536);
  const auto begin = Watch(request)->ReadStep();
  ASSERT_TRUE(begin.has_value());
  EXPECT_THAT(begin->snapshot,
              AllOf(SizeIs(Ge(3U)), Each(Property(&v1::SnapshotChunk::ByteSizeLong, Le(65'536U)))));
  ToldLeaves view;
  view.Take(*begin);
  EXPECT_EQ(view.All(), LeavesByQuery());
}

TEST_P(WatchServiceTest, WrongRequestsAreNamed) {
  const auto kInvalid = StatusCode::kInvalidArgument;
  v1::WatchMapRequest request = Request();
  request.set_map("tenants/test/maps/nobody");
  EXPECT_THAT(ErrorOf(request), IsError(StatusCode::kNotFound, "NOT_FOUND", "map"));
  request.set_map("hall");
  EXPECT_THAT(ErrorOf(request), IsError(kInvalid, "BAD_NAME", "map"));
  EXPECT_THAT(ErrorOf(Request(v1::WATCH_START_UNSPECIFIED)),
              IsError(kInvalid, "BAD_VALUE", "start"));
  request = Request();
  request.set_resume_token("x");
  EXPECT_THAT(ErrorOf(request), IsError(kInvalid, "BAD_VALUE", "start"));
  request.set_start(v1::WATCH_START_UNSPECIFIED);
  EXPECT_THAT(ErrorOf(request), IsError(kInvalid, "BAD_RESUME_TOKEN", "resume_token"));
  request = Request(v1::WATCH_START_NOW);
  request.set_takes_patches(true);
  EXPECT_THAT(ErrorOf(request), IsError(kInvalid, "BAD_VALUE", "takes_patches"));
  request = Request();
  request.set_max_message_bytes(1000);
  EXPECT_THAT(ErrorOf(request), IsError(kInvalid, "BAD_VALUE", "max_message_bytes"));
  request = Request();
  request.mutable_filter()->add_class_ids(70'000);
  EXPECT_THAT(ErrorOf(request), IsError(kInvalid, "BAD_VALUE", "filter.class_ids[0]"));
  request = Request();
  request.mutable_filter()->add_kinds(v1::WATCH_KIND_UNSPECIFIED);
  EXPECT_THAT(ErrorOf(request), IsError(kInvalid, "BAD_VALUE", "filter.kinds[0]"));
  request = Request();
  request.mutable_filter()->add_boxes();
  EXPECT_THAT(ErrorOf(request), IsError(kInvalid, "BAD_VALUE", "filter.boxes[0].min_m"));
}

TEST_P(WatchServiceTest, ADrainingServerSendsEverythingThenSaysGoodbye) {
  const auto watch = Watch(Request());
  ASSERT_TRUE(watch->ReadStep().has_value());
  const std::uint64_t target = Upload();
  std::thread stopping([this] { service_.server().Shutdown(std::chrono::seconds(20)); });
  EXPECT_TRUE(watch->ReadUntil(target).has_value());
  EXPECT_THAT(watch->End(), IsError(StatusCode::kUnavailable, "DRAINING", ""));
  EXPECT_TRUE(watch->was_told_goodbye());
  stopping.join();
}

TEST_P(WatchServiceTest, EndsWhenItsMapIsDeleted) {
  const auto watch = Watch(Request());
  ASSERT_TRUE(watch->ReadStep().has_value());
  ASSERT_TRUE(service_.DeleteMap(map_).ok());
  EXPECT_EQ(watch->End().code(), StatusCode::kNotFound);
}

TEST_P(WatchServiceTest, OneAddressOpensNoMoreThanItsRate) {
  TestService service(GetParam(), [](ServerConfig* config) {
    config->watch.max_watches = 2;
    config->watch.openings_per_second = 1;
  });
  const auto stub = v1::WatchService::NewStub(service.channel());
  v1::WatchMapRequest request;
  request.set_map("tenants/test/maps/nobody");
  absl::Status status = absl::NotFoundError("");
  int openings = 0;
  for (; absl::IsNotFound(status) && openings < 100; ++openings) {
    status = WatchClient(stub.get(), request).End();
  }
  EXPECT_GT(openings, 4) << "a burst of twice the watches that may be open";
  EXPECT_THAT(status, IsError(StatusCode::kResourceExhausted, "RATE_LIMIT", ""));
  EXPECT_EQ(RetryDelayMsOf(status), 1000);
}

TEST_P(WatchServiceTest, NoMoreAreTakenThanAllowedUntilOneEnds) {
  std::vector<std::unique_ptr<WatchClient>> watches;
  for (std::size_t i = 0; i < kMaxWatches; ++i) {
    watches.push_back(Watch(Request()));
    ASSERT_TRUE(watches.back()->ReadStep().has_value());
  }
  EXPECT_THAT(ErrorOf(Request()), IsError(StatusCode::kResourceExhausted, "QUEUE_FULL", ""));
  watches.pop_back();
  // The server receives the end slightly later.
  std::optional<ToldStep> begin;
  while (!begin) begin = Watch(Request())->ReadStep();
  EXPECT_TRUE(begin->created.has_value());
}

}  // namespace
}  // namespace steadymap
