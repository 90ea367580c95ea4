#include "core/map/contradiction.h"

#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "core/map/map_object.h"
#include "core/map/map_snapshot.h"

namespace steadymap {
namespace {

constexpr double kWindowS = 100.0;

const SensorName kSeer{"seer", "camera"};
const SensorName kDoubter{"doubter", "camera"};

Timestamp Second(double seconds) { return Timestamp::FromSeconds(seconds); }

ObjectState SeenAt(double seconds) {
  ObjectState object;
  object.id = ObjectId(1);
  object.status = ObjectStatus::kPresent;
  ReportPresence(kSeer, Second(seconds), &object);
  return object;
}

TEST(Contradiction, IsConfirmedBySessionsThatFindTheObjectGoneAgain) {
  ObjectState object = SeenAt(10.0);
  const Contradiction* contradiction = ReportAbsence(kDoubter, Second(20.0), kWindowS, &object);
  ASSERT_NE(contradiction, nullptr);
  EXPECT_FALSE(contradiction->is_confirmed());
  ReportPresence(kSeer, Second(30.0), &object);
  contradiction = ReportAbsence(kDoubter, Second(40.0), kWindowS, &object);
  ASSERT_NE(contradiction, nullptr);
  EXPECT_TRUE(contradiction->is_confirmed());
  EXPECT_EQ(*contradiction, (Contradiction{kDoubter, kSeer, Second(20.0), Second(40.0), 2}));
}

TEST(Contradiction, IsNoneWithOneself) {
  ObjectState object = SeenAt(10.0);
  EXPECT_EQ(ReportAbsence(kSeer, Second(20.0), kWindowS, &object), nullptr);
  ObjectState of_older_store;
  EXPECT_EQ(ReportAbsence(kDoubter, Second(20.0), kWindowS, &of_older_store), nullptr);
}

TEST(Contradiction, EndsWhenTheSensorThatSawTheObjectFindsItGone) {
  ObjectState object = SeenAt(10.0);
  ReportAbsence(kDoubter, Second(20.0), kWindowS, &object);
  ReportAbsence(kDoubter, Second(30.0), kWindowS, &object);
  EXPECT_EQ(ReportAbsence(kSeer, Second(40.0), kWindowS, &object), nullptr);
  EXPECT_TRUE(object.contradictions.empty());
}

TEST(Contradiction, EndsWhenTheOtherSensorSeesTheObject) {
  ObjectState object = SeenAt(10.0);
  ReportAbsence(kDoubter, Second(20.0), kWindowS, &object);
  ReportPresence(kDoubter, Second(30.0), &object);
  EXPECT_TRUE(object.contradictions.empty());
  EXPECT_EQ(object.source, kDoubter);
  EXPECT_EQ(object.last_seen, Second(30.0));
}

TEST(Contradiction, DoesNotEndByAnOlderSight) {
  ObjectState object = SeenAt(10.0);
  ReportAbsence(kDoubter, Second(20.0), kWindowS, &object);
  ReportPresence(kDoubter, Second(15.0), &object);
  EXPECT_EQ(object.contradictions.size(), 1U) << "a drive that was uploaded late";
}

TEST(Contradiction, NeedsAFreshSight) {
  ObjectState object = SeenAt(10.0);
  ReportAbsence(kDoubter, Second(20.0), kWindowS, &object);
  EXPECT_EQ(ReportAbsence(kDoubter, Second(10.0 + kWindowS + 1.0), kWindowS, &object), nullptr);
  // Once a day, a thing is put down and taken away.
  ReportPresence(kSeer, Second(90'000.0), &object);
  const Contradiction* contradiction = ReportAbsence(kDoubter, Second(90'010.0), kWindowS, &object);
  ASSERT_NE(contradiction, nullptr);
  EXPECT_FALSE(contradiction->is_confirmed());
  EXPECT_EQ(contradiction->since, Second(90'010.0));
}

TEST(Contradiction, AnOldSightDoesNotReplaceANewerOne) {
  ObjectState object = SeenAt(10.0);
  ReportPresence(kDoubter, Second(5.0), &object);
  EXPECT_EQ(object.source, kSeer);
  EXPECT_EQ(object.last_seen, Second(10.0));
}

TEST(Contradiction, OfManySensorsTheNewestStay) {
  ObjectState object = SeenAt(10.0);
  for (std::size_t i = 0; i < 3 * kMaxContradictions; ++i) {
    const SensorName other{"robot-" + std::to_string(i), "camera"};
    ReportAbsence(other, Second(20.0 + static_cast<double>(i)), kWindowS, &object);
    EXPECT_LE(object.contradictions.size(), kMaxContradictions);
    EXPECT_EQ(object.contradictions.back().absent, other);
  }
}

TEST(Contradiction, IsCountedForBothSensors) {
  MapSnapshot map;
  for (std::uint64_t id = 1; id <= 4; ++id) {
    auto object = std::make_shared<MapObject>();
    object->id = ObjectId(id);
    object->status = id == 4 ? ObjectStatus::kArchived : ObjectStatus::kPresent;
    const std::uint32_t sessions = id == 3 ? 1 : 2;
    object->contradictions = {
        {kDoubter, kSeer, Second(100.0 - static_cast<double>(id)), Second(100.0), sessions}};
    map.objects.insert_or_assign(object->id, object);
  }
  const auto contradictions = FindContradictions(map);
  ASSERT_EQ(contradictions.size(), 2U);
  for (const auto& [sensor, other] : {std::pair(kSeer, kDoubter), std::pair(kDoubter, kSeer)}) {
    ASSERT_EQ(contradictions.at(sensor).size(), 1U);
    EXPECT_EQ(contradictions.at(sensor)[0].other, other);
    EXPECT_EQ(contradictions.at(sensor)[0].objects, 2U);
    EXPECT_EQ(contradictions.at(sensor)[0].since, Second(98.0));
  }
}

}  // namespace
}  // namespace steadymap
