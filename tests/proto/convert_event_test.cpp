#include "proto/convert_event.h"

#include <functional>
#include <random>

#include <gtest/gtest.h>

#include "core/types/error.h"
#include "tests/support/special_numbers.h"

namespace steadymap {
namespace {

using ::steadymap::testing::kNan;

constexpr int kTypeCount = 10;
constexpr int kReasonCount = 9;

ObjectEvent RandomEvent(std::mt19937* random) {
  std::uniform_real_distribution<double> place(-100.0, 100.0);
  std::uniform_real_distribution<double> positive(1e-6, 20.0);
  std::uniform_int_distribution<int> type(0, kTypeCount - 1);
  std::uniform_int_distribution<int> why(0, kReasonCount - 1);
  std::uniform_int_distribution<std::uint64_t> large;
  ObjectEvent event;
  event.type = static_cast<EventType>(type(*random));
  event.reason = static_cast<EventReason>(why(*random));
  event.object = ObjectId(large(*random));
  event.class_id = ClassId(static_cast<std::uint16_t>(large(*random)));
  event.time = Timestamp::FromNanoseconds(static_cast<std::int64_t>(large(*random) >> 2));
  event.revision = Revision(large(*random));
  event.center_world = {place(*random), place(*random), place(*random)};
  if (event.type == EventType::kMoved) {
    event.old_center_world = Eigen::Vector3d(place(*random), place(*random), place(*random));
    event.confidence = positive(*random) / 20.0;
    event.move = {{event.center_world, 0.5}, {*event.old_center_world, place(*random)}};
  }
  if (event.type != EventType::kRobotLost && event.type != EventType::kRobotFound) {
    event.before = {place(*random), positive(*random), positive(*random), positive(*random)};
    event.after = {place(*random), positive(*random), positive(*random), positive(*random)};
    event.supporting_frames = large(*random);
    event.contradicted_updates = large(*random);
  }
  if (event.type == EventType::kRobotLost || event.type == EventType::kRobotFound ||
      event.type == EventType::kContradicted) {
    event.source = {"robot-" + std::to_string(large(*random) % 100), "left"};
  }
  event.related = ObjectId(large(*random));
  return event;
}

TEST(ConvertEvent, RandomEventsComeBackBitForBit) {
  std::mt19937 random(1);
  for (int i = 0; i < 1000; ++i) {
    const ObjectEvent event = RandomEvent(&random);
    const v1::ObjectEvent message = ToProto(EventNumber(17), event);
    EXPECT_EQ(message.number(), 17U);
    const absl::StatusOr<ObjectEvent> read = FromProto(message);
    ASSERT_TRUE(read.ok()) << read.status();
    ASSERT_EQ(*read, event);
  }
}

TEST(ConvertEvent, NamesOnTheWireAreThoseOfPrograms) {
  for (int i = 0; i < kTypeCount; ++i) {
    const auto type = static_cast<EventType>(i);
    std::string name = v1::EventType_Name(ToProto(type)).substr(std::string("EVENT_TYPE_").size());
    std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) {
      return static_cast<char>(std::tolower(c));
    });
    EXPECT_EQ(name, NameOf(type));
  }
}

TEST(ConvertEvent, EventsOfRobotsNeedNoBelief) {
  ObjectEvent event;
  event.type = EventType::kRobotLost;
  event.reason = EventReason::kDisagreement;
  v1::ObjectEvent message = ToProto(EventNumber(1), event);
  EXPECT_FALSE(message.has_before());
  EXPECT_TRUE(FromProto(message).ok());
  message.set_type(v1::EVENT_TYPE_REMOVED);
  EXPECT_EQ(FieldOf(FromProto(message).status()), "before.change_std_m");
}

TEST(ConvertEvent, WrongFieldsAreNamed) {
  ObjectEvent moved;
  moved.type = EventType::kMoved;
  moved.old_center_world = Eigen::Vector3d::Ones();
  moved.confidence = 0.5;
  const auto field = [&moved](const std::function<void(v1::ObjectEvent*)>& spoil) {
    v1::ObjectEvent message = ToProto(EventNumber(1), moved);
    spoil(&message);
    const absl::Status status = FromProto(message).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    return FieldOf(status);
  };
  using M = v1::ObjectEvent;
  EXPECT_EQ(field([](M* m) { m->clear_number(); }), "number");
  EXPECT_EQ(field([](M* m) { m->clear_type(); }), "type");
  EXPECT_EQ(field([](M* m) { m->set_type(static_cast<v1::EventType>(-3)); }), "type");
  EXPECT_EQ(field([](M* m) { m->clear_reason(); }), "reason");
  EXPECT_EQ(field([](M* m) { m->set_reason(static_cast<v1::EventReason>(99)); }), "reason");
  EXPECT_EQ(field([](M* m) { m->set_class_id(65536); }), "class_id");
  EXPECT_EQ(field([](M* m) { m->mutable_capture_time()->set_nanos(-1); }), "capture_time.nanos");
  EXPECT_EQ(field([](M* m) { m->clear_center_m(); }), "center_m");
  EXPECT_EQ(field([](M* m) { m->mutable_center_m()->set_x(kNan); }), "center_m");
  EXPECT_EQ(field([](M* m) { m->mutable_old_center_m()->set_z(kNan); }), "old_center_m");
  EXPECT_EQ(field([](M* m) { m->set_confidence(1.01); }), "confidence");
  EXPECT_EQ(field([](M* m) { m->set_confidence(kNan); }), "confidence");
  EXPECT_EQ(field([](M* m) { m->set_robot("Robot 1"); }), "robot");
  EXPECT_EQ(field([](M* m) { m->mutable_before()->set_alpha(0.0); }), "before.alpha");
  EXPECT_EQ(field([](M* m) { m->mutable_after()->set_beta(kNan); }), "after.beta");
}

}  // namespace
}  // namespace steadymap
