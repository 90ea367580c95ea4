#include "client/bench/evaluation/score/event_score.h"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "client/bench/evaluation/score/event_faults.h"

namespace steadymap {
namespace {

const ClassId kGoods{7};
const ClassId kWall{4};

Eigen::AlignedBox3d BoxAt(double x, double y) {
  const Eigen::Vector3d half(0.25, 0.25, 1.0);
  const Eigen::Vector3d center(x, y, 1.0);
  return {center - half, center + half};
}

ChangeEnd EndAt(double x, double y) { return {{BoxAt(x, y)}, true, {12, 14, 15}}; }

// Two sequences of ten frames, one second apart. In the second a box has been removed from (0, 0),
// one has been added at (4, 0), and one has moved from (8, 0) to (12, 0).
EventTruth Truth() {
  EventTruth truth;
  truth.first_frames = {0, 10, 20};
  for (int i = 0; i < 20; ++i) truth.capture_times.push_back(Timestamp::FromSeconds(100.0 + i));
  truth.changes = {{"gone", kGoods, 1, EndAt(0, 0), {}},
                   {"new", kGoods, 1, {}, EndAt(4, 0)},
                   {"moved", kGoods, 1, EndAt(8, 0), EndAt(12, 0)}};
  return truth;
}

ObjectEvent Event(EventType type, double x, int frame, ClassId class_id = kGoods) {
  ObjectEvent event;
  event.type = type;
  event.class_id = class_id;
  event.time = Timestamp::FromSeconds(100.0 + frame);
  event.center_world = {x, 0.0, 0.9};
  return event;
}

ObjectEvent MoveEvent(double from_x, double to_x, int frame) {
  ObjectEvent event = Event(EventType::kMoved, to_x, frame);
  event.old_center_world = Eigen::Vector3d(from_x, 0.0, 0.9);
  return event;
}

std::vector<ObjectEvent> PerfectEvents() {
  return {Event(EventType::kRemoved, 0.1, 14),
          Event(EventType::kCreated, 4.1, 12),
          MoveEvent(8.1, 11.9, 15)};
}

TEST(ScoreEvents, PerfectEventsHaveNoFault) {
  const EventScore score = ScoreEvents(Truth(), PerfectEvents());
  for (const DetectionScores& scores : {score.lenient, score.one_to_one}) {
    for (const DetectionScore& kind : {scores.created, scores.removed, scores.moved}) {
      EXPECT_EQ(kind.precision(), 1.0);
      EXPECT_EQ(kind.recall(), 1.0);
      EXPECT_EQ(kind.f1(), 1.0);
    }
    EXPECT_EQ(scores.created.found.whole, 2U);
    EXPECT_EQ(scores.removed.found.whole, 2U);
    EXPECT_EQ(scores.moved.found.whole, 1U);
  }
  EXPECT_EQ(score.false_removals, 0U);
  EXPECT_EQ(score.latency_frames, (std::vector<std::size_t>{1, 2, 3, 3}));
  EXPECT_EQ(score.median_latency_frames(), 3.0);
}

TEST(EventScore, TellsTheMiddleAndTheLastLatency) {
  EventScore score;
  score.latency_frames = {1, 4, 20};
  EXPECT_EQ(score.median_latency_frames(), 4.0);
  EXPECT_EQ(score.max_latency_frames(), 20.0);
}

TEST(ScoreEvents, WithoutEventsNothingIsFound) {
  const EventScore score = ScoreEvents(Truth(), {});
  EXPECT_EQ(score.lenient.all().recall(), 0.0);
  EXPECT_TRUE(std::isnan(score.lenient.all().precision()));
  EXPECT_TRUE(std::isnan(score.median_latency_frames()));
  EXPECT_TRUE(std::isnan(score.max_latency_frames()));
  EXPECT_EQ(score.false_removals_per_1000_frames(), 0.0);
}

TEST(ScoreEvents, AMoveToldAsTwoEventsIsAMoveOnlyLeniently) {
  const EventScore score = ScoreEvents(
      Truth(), {Event(EventType::kRemoved, 8.0, 12), Event(EventType::kCreated, 12.0, 14)});
  EXPECT_EQ(score.lenient.moved.recall(), 1.0);
  EXPECT_EQ(score.one_to_one.moved.recall(), 0.0);
  EXPECT_EQ(score.one_to_one.removed.found.part, 1U);
  EXPECT_EQ(score.one_to_one.created.found.part, 1U);
}

TEST(ScoreEvents, ASecondEventForOneChangeIsRightOnlyLeniently) {
  std::vector<ObjectEvent> events = PerfectEvents();
  events.push_back(Event(EventType::kRemoved, 0.0, 16));
  const EventScore score = ScoreEvents(Truth(), events);
  EXPECT_EQ(score.lenient.removed.precision(), 1.0);
  EXPECT_NEAR(score.one_to_one.removed.precision(), 2.0 / 3.0, 1e-12);
  EXPECT_EQ(score.one_to_one.removed.recall(), 1.0);
}

TEST(ScoreEvents, AGroupTakesAnEventForEachOfItsThings) {
  EventTruth truth = Truth();
  truth.changes[0].departure.boxes_world.push_back(BoxAt(0.5, 0));
  for (const std::vector<double>& places : {std::vector<double>{0.25}, {0.0, 0.5}}) {
    std::vector<ObjectEvent> events;
    events.reserve(places.size());
    for (const double x : places) events.push_back(Event(EventType::kRemoved, x, 14));
    const EventScore score = ScoreEvents(truth, events);
    EXPECT_EQ(score.one_to_one.removed.precision(), 1.0);
    EXPECT_EQ(score.one_to_one.removed.found.part, 1U);
    EXPECT_EQ(score.one_to_one.removed.found.whole, 2U);
  }
}

TEST(ScoreEvents, EventsAtOverlappingPlacesAreSharedOut) {
  EventTruth truth = Truth();
  truth.changes.push_back({"gone-too", kGoods, 1, EndAt(0.6, 0), {}});
  // The first event fits both places, the second only the place of the first change.
  const EventScore score = ScoreEvents(
      truth, {Event(EventType::kRemoved, 0.3, 12), Event(EventType::kRemoved, -0.3, 12)});
  EXPECT_EQ(score.one_to_one.removed.right.part, 2U);
  EXPECT_EQ(score.one_to_one.removed.found.part, 2U);
}

TEST(ScoreEvents, WrongClassPlaceOrTimeIsWrong) {
  for (const ObjectEvent& event : {Event(EventType::kRemoved, 0.0, 14, kWall),
                                   Event(EventType::kRemoved, 0.7, 14),
                                   Event(EventType::kRemoved, 0.0, 9)}) {
    const EventScore score = ScoreEvents(Truth(), {event});
    EXPECT_EQ(score.lenient.removed.found.part, 0U);
    EXPECT_EQ(score.lenient.removed.right.part, 0U);
    EXPECT_EQ(score.false_removals, 1U);
    EXPECT_EQ(score.false_removals_per_1000_frames(), 50.0);
  }
}

TEST(ScoreEvents, WhatCouldNotBeSeenIsNotAskedForButMayBeTold) {
  EventTruth truth = Truth();
  truth.changes[0].departure.is_in_view = false;
  EXPECT_EQ(ScoreEvents(truth, {}).lenient.removed.found.whole, 1U);
  const EventScore score = ScoreEvents(truth, {Event(EventType::kRemoved, 0.0, 14)});
  EXPECT_EQ(score.lenient.removed.precision(), 1.0);
  EXPECT_EQ(score.one_to_one.removed.precision(), 1.0);
}

TEST(ScoreEvents, FirstSightsAndTheFirstSequenceAreNeitherRightNorWrong) {
  EventTruth truth = Truth();
  truth.first_sights = {{kWall, 1, BoxAt(20, 0)}};
  const EventScore score = ScoreEvents(truth,
                                       {Event(EventType::kCreated, 30.0, 3),
                                        Event(EventType::kCreated, 20.0, 12, kWall),
                                        Event(EventType::kUpdated, 30.0, 12)});
  EXPECT_EQ(score.lenient.created.right.whole, 0U);
  const EventScore again = ScoreEvents(truth, {Event(EventType::kCreated, 30.0, 12)});
  EXPECT_EQ(again.lenient.created.precision(), 0.0);
}

TEST(ListEventFaults, PerfectEventsHaveNone) {
  EXPECT_TRUE(ListEventFaults(Truth(), PerfectEvents()).empty());
}

TEST(ListEventFaults, TellsWhatIsMissingFalseOrTooOften) {
  const std::vector<std::string> faults = ListEventFaults(Truth(),
                                                          {Event(EventType::kCreated, 4.1, 12),
                                                           Event(EventType::kCreated, 3.9, 13),
                                                           Event(EventType::kRemoved, 8.1, 14),
                                                           Event(EventType::kCreated, 11.9, 15),
                                                           Event(EventType::kRemoved, 30.0, 16)});
  EXPECT_EQ(faults,
            (std::vector<std::string>{
                "missing: departure of gone, class 7, at (0.00, 0.00, 1.00), sequence 1",
                "told twice: arrival of new, class 7, at (4.00, 0.00, 1.00), sequence 1",
                "not told as moved: departure of moved, class 7, at (8.00, 0.00, 1.00), sequence 1",
                "not told as moved: arrival of moved, class 7, at (12.00, 0.00, 1.00), sequence 1",
                "false: departure told by removed, class 7, at (30.00, 0.00, 0.90), frame 16"}));
}

TEST(ScoreEvents, CountsOfSeveralRunsAddUp) {
  EventScore sum = ScoreEvents(Truth(), PerfectEvents());
  sum += ScoreEvents(Truth(), {});
  EXPECT_EQ(sum.lenient.all().recall(), 0.5);
  EXPECT_EQ(sum.lenient.all().precision(), 1.0);
  EXPECT_EQ(sum.frame_count, 40U);
}

}  // namespace
}  // namespace steadymap
