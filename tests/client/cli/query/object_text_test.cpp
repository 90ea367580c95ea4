#include "client/cli/query/object_text.h"

#include <sstream>

#include <gtest/gtest.h>

#include "client/cli/text/enumerator_text.h"
#include "proto/convert_event.h"
#include "proto/convert_map.h"
#include "proto/convert_object.h"

namespace steadymap {
namespace {

ClassNames Torwic() { return ClassNames(ToProto(MapConfig())); }

MapObject Cart() {
  MapObject object;
  object.id = ObjectId(12);
  object.status = ObjectStatus::kPresent;
  object.class_id = ClassId(9);
  object.votes = {{ClassId(9), 2.0}};
  object.cuboid = {{1.0, -2.0, 0.5}, {0.5, 0.25, 1.0}, 0.125};
  object.belief = {0.25, 0.5, 3.0, 1.0};
  object.first_seen = Timestamp::FromSeconds(100.5);
  object.last_seen = Timestamp::FromSeconds(200.0);
  object.supporting_frames = 7;
  object.contradicted_updates = 2;
  object.revision = Revision(42);
  return object;
}

ObjectEvent CartMoved() {
  ObjectEvent event;
  event.type = EventType::kMoved;
  event.reason = EventReason::kShapeMatched;
  event.object = ObjectId(12);
  event.class_id = ClassId(9);
  event.time = Timestamp::FromSeconds(150.0);
  event.revision = Revision(40);
  event.center_world = {1.0, -2.0, 0.5};
  event.old_center_world = Eigen::Vector3d(4.0, 5.0, 0.5);
  event.confidence = 0.75;
  event.after.alpha = 3.0;
  event.supporting_frames = 21;
  event.contradicted_updates = 2;
  return event;
}

TEST(ObjectJson, HasTheDocumentedKeys) {
  EXPECT_EQ(ObjectJson(ToProto(Cart()), Torwic()), Json::parse(R"({
    "id": 12, "class": 9, "class_name": "cart/pallet jack", "class_confidence": 1,
    "standing": "present", "center": [1, -2, 0.5], "yaw": 0.125, "size": [0.5, 0.25, 1],
    "stationarity": 0.75, "alpha": 3, "beta": 1, "change_mean_m": 0.25, "change_std_m": 0.5,
    "first_seen": 100.5, "last_seen": 200, "views": 7, "absences": 2, "revision": 42, "leaves": 0,
    "contradictions": []
  })"));
}

MapObject ContradictedCart() {
  MapObject object = Cart();
  object.contradictions = {{{"dolly", "left"},
                            {"forklift-2", "front"},
                            Timestamp::FromSeconds(120.0),
                            Timestamp::FromSeconds(180.0),
                            3}};
  return object;
}

TEST(ObjectJson, NamesTheSensorsThatDisagree) {
  EXPECT_EQ(ObjectJson(ToProto(ContradictedCart()), Torwic()).at("contradictions"), Json::parse(R"([
    {"present": ["forklift-2", "front"], "absent": ["dolly", "left"], "since": 120, "last": 180,
     "sessions": 3}])"));
}

TEST(EventJson, AMoveHasBothCentresAndItsConfidence) {
  EXPECT_EQ(EventJson(ToProto(EventNumber(5), CartMoved()), Torwic()), Json::parse(R"({
    "number": 5, "type": "moved", "reason": "shape_matched", "object": 12, "class": 9,
    "class_name": "cart/pallet jack", "time": 150, "revision": 40, "center": [1, -2, 0.5],
    "old_center": [4, 5, 0.5], "new_center": [1, -2, 0.5], "confidence": 0.75,
    "views": 21, "absences": 2,
    "before": {"stationarity": 0.5, "alpha": 1, "beta": 1, "change_mean_m": 0, "change_std_m": 0.5},
    "after": {"stationarity": 0.75, "alpha": 3, "beta": 1, "change_mean_m": 0, "change_std_m": 0.5}
  })"));
}

TEST(EventJson, WhatAnEventLacksIsLeftOut) {
  ObjectEvent event = CartMoved();
  event.type = EventType::kMerged;
  event.old_center_world.reset();
  event.confidence.reset();
  event.related = ObjectId(3);
  const Json merged = EventJson(ToProto(EventNumber(6), event), Torwic());
  for (const char* key : {"confidence", "old_center", "new_center"}) {
    EXPECT_FALSE(merged.contains(key)) << key;
  }
  EXPECT_EQ(merged.at("related"), 3);
}

ObjectEvent RobotLost() {
  ObjectEvent event;
  event.type = EventType::kRobotLost;
  event.reason = EventReason::kDisagreement;
  event.time = Timestamp::FromSeconds(150.0);
  event.revision = Revision(40);
  event.source = {"forklift-2", "left"};
  return event;
}

TEST(EventJson, AnEventOfARobotNamesIt) {
  EXPECT_EQ(EventJson(ToProto(EventNumber(7), RobotLost()), Torwic()), Json::parse(R"({
    "number": 7, "type": "robot_lost", "reason": "disagreement", "object": 0, "class": 0,
    "class_name": "background", "time": 150, "revision": 40, "center": [0, 0, 0],
    "robot": "forklift-2", "sensor": "left"
  })"));
}

TEST(ObjectTable, HasALineAnObject) {
  std::ostringstream out;
  WriteObjectTable({ToProto(Cart())}, Torwic(), &out);
  EXPECT_EQ(out.str(),
            "    ID  CLASS             CENTRE [m]              SIZE [m]             E[v]   VIEWS  "
            "STANDING   LAST SEEN\n"
            "    12  cart/pallet jack  (1.00, -2.00, 0.50)     (0.50, 0.25, 1.00)   0.75   7      "
            "present    1970-01-01T00:03:20Z\n");
}

TEST(ObjectTable, MarksWhatRobotsDisagreeAbout) {
  std::ostringstream out;
  WriteObjectTable({ToProto(ContradictedCart())}, Torwic(), &out);
  EXPECT_NE(out.str().find("1970-01-01T00:03:20Z  contradicted\n"), std::string::npos);
}

TEST(EventLines, SayWhatHappenedToWhom) {
  std::ostringstream out;
  WriteEventLines({ToProto(EventNumber(5), CartMoved())}, Torwic(), &out);
  EXPECT_EQ(out.str(),
            "     5  1970-01-01T00:02:30Z  revision 40  moved (shape_matched)  object 12 "
            "(cart/pallet jack) from (4.00, 5.00, 0.50) to (1.00, -2.00, 0.50), confidence 0.75, "
            "E[v] 0.50 -> 0.75\n");
}

TEST(EventLines, SayForWhomAnObjectIsGone) {
  ObjectEvent event = CartMoved();
  event.type = EventType::kContradicted;
  event.reason = EventReason::kDisagreement;
  event.old_center_world.reset();
  event.confidence.reset();
  event.source = {"dolly", "left"};
  std::ostringstream out;
  WriteEventLines({ToProto(EventNumber(8), event)}, Torwic(), &out);
  EXPECT_EQ(out.str(),
            "     8  1970-01-01T00:02:30Z  revision 40  contradicted (disagreement)  object 12 "
            "(cart/pallet jack) at (1.00, -2.00, 0.50), gone for robot dolly/left, "
            "E[v] 0.50 -> 0.75\n");
}

TEST(EventLines, SayWhichRobotIsLost) {
  std::ostringstream out;
  WriteEventLines({ToProto(EventNumber(7), RobotLost())}, Torwic(), &out);
  EXPECT_EQ(out.str(),
            "     7  1970-01-01T00:02:30Z  revision 40  robot_lost (disagreement)  robot "
            "forklift-2/left\n");
}

TEST(ClassNames, AClassIsKnownByItsNameAndItsId) {
  EXPECT_EQ(Torwic().NameOf(7), "goods materials");
  EXPECT_EQ(Torwic().NameOf(70), "class 70");
  EXPECT_EQ(*Torwic().Parse("goods materials"), ClassId(7));
  EXPECT_EQ(*Torwic().Parse("7"), ClassId(7));
  EXPECT_EQ(*Torwic().Parse("65535"), ClassId(65535));
  for (const char* text : {"", "goods", "65536", "-1", "7x"}) {
    EXPECT_EQ(Torwic().Parse(text).status().code(), absl::StatusCode::kInvalidArgument) << text;
  }
}

TEST(EnumeratorText, WordsStandForEnumerators) {
  EXPECT_EQ(WordOf(v1::EventReason_descriptor(), v1::EVENT_REASON_SEEN_THROUGH), "seen_through");
  EXPECT_EQ(WordOf(v1::EventType_descriptor(), 0), "unknown");
  EXPECT_EQ(WordOf(v1::EventType_descriptor(), 999), "unknown");
  EXPECT_EQ(NumberOf(v1::UpdatePolicy_descriptor(), "pocd"), v1::UPDATE_POLICY_POCD);
  for (const char* word : {"", "POCD", "unspecified", "unknown"}) {
    EXPECT_EQ(NumberOf(v1::UpdatePolicy_descriptor(), word), 0) << word;
  }
  EXPECT_EQ(WordsOf(v1::ObjectStanding_descriptor()), "tentative, present, archived");
}

TEST(ParseEventType, AnUnknownTypeIsAnErrorThatListsTheTypes) {
  EXPECT_EQ(*ParseEventType("robot_lost"), v1::EVENT_TYPE_ROBOT_LOST);
  const absl::Status status = ParseEventType("exploded").status();
  EXPECT_NE(status.message().find("created, updated, moved"), absl::string_view::npos) << status;
}

}  // namespace
}  // namespace steadymap
