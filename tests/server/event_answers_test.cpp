#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "server/object_answers.h"
#include "tests/server/store_builder.h"
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
    const absl::Status status =
        AnswerListEvents(store_, map_, Revision(revision), request, &response);
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
  const auto count = [&](const v1::ListEventsRequest& request) {
    v1::ListEventsResponse response;
    EXPECT_TRUE(AnswerListEvents(store, map, Revision(1), request, &response).ok());
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
