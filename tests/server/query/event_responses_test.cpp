#include "server/query/event_responses.h"

#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/types/error.h"
#include "tests/server/store/store_builder.h"
#include "tests/support/memory_store.h"

namespace steadymap {
namespace {

/// A map with a long history: events of object 1, and a last one of object 2.
class LongHistory : public ::testing::Test {
 protected:
  static constexpr std::uint64_t kEvents = 150'000;

  LongHistory() {
    map_ = store_.CreateMap(MakeMapRecord("test", "hall"))->key;
    EXPECT_TRUE(store_.Append(MakeAppend(map_, 1, 2)).ok());
    MapDelta delta = MakeDelta(0, 1, {});
    ObjectEvent event = MakeEvent(EventType::kUpdated, 1, 1);
    event.revision = Revision(1);
    delta.events.assign(kEvents - 1, event);
    event.object = ObjectId(2);
    delta.events.push_back(event);
    EXPECT_TRUE(store_.CommitRevision(map_, delta, {}).ok());
    MapDelta later = MakeDelta(1, 2, {});
    event.revision = Revision(2);
    later.events.push_back(event);
    EXPECT_TRUE(store_.CommitRevision(map_, later, {}).ok());
  }

  v1::ListEventsResponse List(const v1::ListEventsRequest& request, std::uint64_t revision) {
    v1::ListEventsResponse response;
    MapSnapshot snapshot;
    snapshot.revision = Revision(revision);
    snapshot.last_event = EventNumber(revision == 1 ? kEvents : kEvents + 1);
    const absl::Status status =
        AnswerListEvents(store_, map_, snapshot, request, Cancellation(), &response);
    EXPECT_TRUE(status.ok()) << status;
    return response;
  }

  MemoryStore store_;
  MapKey map_;
};

TEST_F(LongHistory, APageEndsWhenTooManyEventsWerePassedOver) {
  v1::ListEventsRequest request;
  request.add_object_ids(2);
  const v1::ListEventsResponse first = List(request, 1);
  EXPECT_EQ(first.events_size(), 0);
  ASSERT_NE(first.next_page_token(), "");
  request.set_page_token(first.next_page_token());
  const v1::ListEventsResponse second = List(request, 1);
  ASSERT_EQ(second.events_size(), 1);
  EXPECT_EQ(second.events(0).number(), kEvents);
  EXPECT_EQ(second.next_page_token(), "");
}

TEST_F(LongHistory, EventsOfLaterRevisionsAreNotShown) {
  v1::ListEventsRequest request;
  request.set_first_number(kEvents);
  EXPECT_EQ(List(request, 1).events_size(), 1);
  EXPECT_EQ(List(request, 2).events_size(), 2);
}

TEST_F(LongHistory, PagesOfOneListingTellWhatHadHappenedByTheFirst) {
  v1::ListEventsRequest request;
  request.set_first_number(kEvents - 1);
  request.set_page_size(1);
  const v1::ListEventsResponse first = List(request, 1);
  ASSERT_EQ(first.events_size(), 1);
  request.set_page_token(first.next_page_token());
  request.set_page_size(10);
  const v1::ListEventsResponse second = List(request, 2);
  EXPECT_EQ(second.revision(), 1U);
  ASSERT_EQ(second.events_size(), 1) << "the event of revision 2 is none of the listing";
  EXPECT_EQ(second.events(0).number(), kEvents);
  EXPECT_EQ(second.next_page_token(), "");
}

TEST_F(LongHistory, ATokenGoesWithItsFiltersAlone) {
  v1::ListEventsRequest request;
  request.set_page_size(1);
  const std::string token = List(request, 1).next_page_token();
  request.set_page_token(token);
  EXPECT_EQ(List(request, 1).events(0).number(), 2U);
  const auto refused = [&](const v1::ListEventsRequest& changed) {
    v1::ListEventsResponse response;
    return AnswerListEvents(store_, map_, MapSnapshot(), changed, {}, &response);
  };
  std::vector<v1::ListEventsRequest> changed(6, request);
  changed[0].add_types(v1::EVENT_TYPE_UPDATED);
  changed[1].add_object_ids(1);
  changed[2].add_class_ids(0);
  changed[3].set_first_number(1);
  changed[4].mutable_start_time()->set_seconds(1);
  changed[5].mutable_end_time()->set_seconds(1);
  for (const v1::ListEventsRequest& other : changed) {
    EXPECT_EQ(ReasonOf(refused(other)), "BAD_PAGE_TOKEN") << other.ShortDebugString();
    EXPECT_EQ(FieldOf(refused(other)), "page_token");
  }
}

TEST_F(LongHistory, APageEndsAtItsBytes) {
  v1::ListEventsRequest request;
  request.set_page_size(10'000);
  std::uint64_t expected = 1;
  for (int page = 0; page < 3; ++page) {
    const v1::ListEventsResponse response = List(request, 1);
    EXPECT_LT(response.ByteSizeLong(), std::size_t{2} << 20);
    ASSERT_GT(response.events_size(), 100);
    for (const v1::ObjectEvent& event : response.events()) EXPECT_EQ(event.number(), expected++);
    request.set_page_token(response.next_page_token());
  }
}

TEST_F(LongHistory, ReadingEndsWithTheBatchOnceItIsCancelled) {
  v1::ListEventsRequest request;
  request.add_object_ids(2);
  for (const int wanted_for : {0, 1, 7}) {
    int asked = 0;
    const Cancellation later([&] { return asked++ >= wanted_for; });
    v1::ListEventsResponse response;
    MapSnapshot snapshot;
    snapshot.last_event = EventNumber(kEvents);
    EXPECT_TRUE(
        absl::IsCancelled(AnswerListEvents(store_, map_, snapshot, request, later, &response)));
    EXPECT_EQ(asked, wanted_for + 1);
  }
}

TEST(TimesOfEvents, FromTheStartToBeforeTheEnd) {
  MemoryStore store;
  const MapKey map = store.CreateMap(MakeMapRecord("test", "hall"))->key;
  ASSERT_TRUE(store.Append(MakeAppend(map, 1, 1)).ok());
  MapDelta delta = MakeDelta(0, 1, {});
  ObjectEvent event = MakeEvent(EventType::kUpdated, 1, 1);
  event.revision = Revision(1);
  for (const std::int64_t second : {10, 20, 30}) {
    event.time = Timestamp::FromNanoseconds(second * 1'000'000'000);
    delta.events.push_back(event);
  }
  ASSERT_TRUE(store.CommitRevision(map, delta, {}).ok());
  MapSnapshot snapshot;
  snapshot.revision = Revision(1);
  snapshot.last_event = EventNumber(3);
  v1::ListEventsRequest request;
  request.mutable_start_time()->set_seconds(20);
  request.mutable_end_time()->set_seconds(30);
  v1::ListEventsResponse response;
  ASSERT_TRUE(AnswerListEvents(store, map, snapshot, request, {}, &response).ok());
  ASSERT_EQ(response.events_size(), 1);
  EXPECT_EQ(response.events(0).number(), 2U);
  request.mutable_end_time()->set_seconds(19);
  EXPECT_EQ(FieldOf(AnswerListEvents(store, map, snapshot, request, {}, &response)), "end_time");
}

TEST(EventsOfRobots, PassNoFilterOfObjects) {
  MemoryStore store;
  const MapKey map = store.CreateMap(MakeMapRecord("test", "hall"))->key;
  ASSERT_TRUE(store.Append(MakeAppend(map, 1, 1)).ok());
  MapDelta delta = MakeDelta(0, 1, {});
  ObjectEvent lost;
  lost.type = EventType::kRobotLost;
  lost.source.robot = "robot-7";
  lost.revision = Revision(1);
  delta.events = {lost};
  ASSERT_TRUE(store.CommitRevision(map, delta, {}).ok());
  MapSnapshot snapshot;
  snapshot.revision = Revision(1);
  snapshot.last_event = EventNumber(1);
  const auto count = [&](const v1::ListEventsRequest& request) {
    v1::ListEventsResponse response;
    EXPECT_TRUE(AnswerListEvents(store, map, snapshot, request, {}, &response).ok());
    return response.events_size();
  };
  v1::ListEventsRequest any;
  any.add_types(v1::EVENT_TYPE_ROBOT_LOST);
  EXPECT_EQ(count(any), 1);
  v1::ListEventsRequest of_object = any;
  of_object.add_object_ids(0);
  EXPECT_EQ(count(of_object), 0);
  v1::ListEventsRequest of_class = any;
  of_class.add_class_ids(0);
  EXPECT_EQ(count(of_class), 0);
}

}  // namespace
}  // namespace steadymap
