#include "proto/convert_object.h"

#include <functional>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "core/types/error.h"
#include "tests/support/special_numbers.h"

namespace steadymap {
namespace {

using ::steadymap::testing::kInfinity;
using ::steadymap::testing::kNan;

Eigen::Vector3d RandomVector(std::mt19937* random, double low, double high) {
  std::uniform_real_distribution<double> number(low, high);
  return {number(*random), number(*random), number(*random)};
}

MapObject RandomObject(std::mt19937* random) {
  std::uniform_real_distribution<double> positive(1e-6, 20.0);
  std::uniform_real_distribution<double> angle(-10.0, 10.0);
  std::uniform_int_distribution<int> small(0, 3);
  std::uniform_int_distribution<std::uint64_t> large(1);
  std::uniform_int_distribution<std::int64_t> time(0, 4'000'000'000'000'000'000);
  MapObject object;
  object.id = ObjectId(large(*random));
  object.status = std::array{ObjectStatus::kTentative,
                             ObjectStatus::kPresent,
                             ObjectStatus::kArchived}[large(*random) % 3];
  object.revision = Revision(large(*random));
  object.class_id = ClassId(static_cast<std::uint16_t>(large(*random)));
  for (int i = 0; i < small(*random); ++i) {
    object.votes.push_back({ClassId(static_cast<std::uint16_t>(7 * i)), positive(*random)});
  }
  object.T_world_object = {RandomVector(random, -9000.0, 9000.0), angle(*random)};
  object.cuboid = {
      RandomVector(random, -9000.0, 9000.0), RandomVector(random, 0.0, 9.0), angle(*random)};
  object.belief = {angle(*random), positive(*random), positive(*random), positive(*random)};
  object.evidence.present_cells = positive(*random);
  object.evidence.absent_cells = positive(*random);
  object.first_seen = Timestamp::FromNanoseconds(time(*random));
  object.last_seen = Timestamp::FromNanoseconds(time(*random));
  object.supporting_frames = large(*random);
  object.contradicted_updates = large(*random);
  for (int i = 0; i < small(*random); ++i) {
    object.contradictions.push_back({{"robot-" + std::to_string(i), "left"},
                                     {"robot-9", "right"},
                                     Timestamp::FromNanoseconds(time(*random)),
                                     Timestamp::FromNanoseconds(time(*random)),
                                     2 + static_cast<std::uint32_t>(i)});
  }
  return object;
}

TEST(ConvertObject, RandomStatesComeBackBitForBit) {
  std::mt19937 random(3);
  for (int i = 0; i < 1000; ++i) {
    const MapObject object = RandomObject(&random);
    const absl::StatusOr<ObjectState> read = FromProto(ToProto(object));
    ASSERT_TRUE(read.ok()) << read.status();
    ASSERT_EQ(*read, static_cast<const ObjectState&>(object));
  }
}

TEST(ConvertObject, TheEvidenceOfSingleLeavesStaysAtHome) {
  std::mt19937 random(4);
  MapObject object = RandomObject(&random);
  object.evidence.MutableLeaf({8, 16, 24}).score[0] = 2;
  const absl::StatusOr<ObjectState> read = FromProto(ToProto(object));
  ASSERT_TRUE(read.ok()) << read.status();
  object.evidence.leaves.clear();
  EXPECT_EQ(*read, static_cast<const ObjectState&>(object));
}

TEST(ConvertObject, OneAbsenceIsNoContradiction) {
  MapObject object;
  object.contradictions = {{{"other", "camera"}, {"one", "camera"}, {}, {}, 1}};
  EXPECT_EQ(ToProto(object).contradictions_size(), 0);
}

TEST(ConvertObject, WhatFollowsFromTheStateIsToldToo) {
  MapObject object;
  object.id = ObjectId(1);
  object.class_id = ClassId(7);
  object.votes = {{ClassId(4), 1.0}, {ClassId(7), 3.0}};
  object.belief.alpha = 6.0;
  object.belief.beta = 2.0;
  auto volume = std::make_shared<TsdfGrid>();
  LeafVoxels voxels;
  voxels.observed[0] = 1;
  volume->StoreLeaf({0, 0, 0}, voxels);
  volume->StoreLeaf({8, 0, 0}, voxels);
  object.volume = volume;
  const v1::Object message = ToProto(object);
  EXPECT_EQ(message.class_confidence(), 0.75);
  EXPECT_EQ(message.stationarity(), 0.75);
  EXPECT_EQ(message.leaves(), 2U);
}

TEST(ConvertObject, AnObjectWithoutVotesHasNoConfidence) {
  MapObject object;
  EXPECT_EQ(ToProto(object).class_confidence(), 0.0);
  object.votes = {{ClassId(3), 0.0}};
  EXPECT_EQ(ToProto(object).class_confidence(), 0.0);
}

TEST(ConvertObject, WrongFieldsAreNamed) {
  std::mt19937 random(5);
  MapObject object = RandomObject(&random);
  object.votes = {{ClassId(1), 1.0}, {ClassId(2), 1.0}};
  const auto field = [&object](const std::function<void(v1::Object*)>& spoil) {
    v1::Object message = ToProto(object);
    spoil(&message);
    const absl::Status status = FromProto(message).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    return FieldOf(status);
  };
  using M = v1::Object;
  EXPECT_EQ(field([](M* m) { m->clear_id(); }), "id");
  EXPECT_EQ(field([](M* m) { m->clear_standing(); }), "standing");
  EXPECT_EQ(field([](M* m) { m->set_standing(static_cast<v1::ObjectStanding>(9)); }), "standing");
  EXPECT_EQ(field([](M* m) { m->set_class_id(65536); }), "class_id");
  EXPECT_EQ(field([](M* m) { m->mutable_votes(1)->set_class_id(1); }), "votes[1].class_id");
  EXPECT_EQ(field([](M* m) { m->mutable_votes(1)->set_class_id(70'000); }), "votes[1].class_id");
  EXPECT_EQ(field([](M* m) { m->mutable_votes(0)->set_weight(-1e-9); }), "votes[0].weight");
  EXPECT_EQ(field([](M* m) { m->clear_cuboid(); }), "cuboid.center_m");
  EXPECT_EQ(field([](M* m) { m->mutable_cuboid()->mutable_center_m()->set_y(kNan); }),
            "cuboid.center_m");
  EXPECT_EQ(field([](M* m) { m->mutable_cuboid()->clear_size_m(); }), "cuboid.size_m");
  EXPECT_EQ(field([](M* m) { m->mutable_cuboid()->mutable_size_m()->set_z(-0.1); }),
            "cuboid.size_m");
  EXPECT_EQ(field([](M* m) { m->mutable_cuboid()->mutable_size_m()->set_z(kNan); }),
            "cuboid.size_m");
  EXPECT_EQ(field([](M* m) { m->mutable_cuboid()->set_yaw_rad(kInfinity); }), "cuboid.yaw_rad");
  EXPECT_EQ(field([](M* m) { m->clear_world_from_object(); }), "world_from_object.position_m");
  EXPECT_EQ(
      field([](M* m) { m->mutable_world_from_object()->mutable_position_m()->set_x(10'001.0); }),
      "world_from_object.position_m");
  EXPECT_EQ(field([](M* m) { m->mutable_world_from_object()->set_yaw_rad(kNan); }),
            "world_from_object.yaw_rad");
  EXPECT_EQ(field([](M* m) { m->clear_belief(); }), "belief.change_std_m");
  EXPECT_EQ(field([](M* m) { m->mutable_belief()->set_change_mean_m(kNan); }),
            "belief.change_mean_m");
  EXPECT_EQ(field([](M* m) { m->mutable_belief()->set_change_std_m(0.0); }), "belief.change_std_m");
  EXPECT_EQ(field([](M* m) { m->mutable_belief()->set_alpha(kInfinity); }), "belief.alpha");
  EXPECT_EQ(field([](M* m) { m->mutable_belief()->set_beta(-1.0); }), "belief.beta");
  EXPECT_EQ(field([](M* m) { m->mutable_first_seen()->set_seconds(-1); }), "first_seen.seconds");
  EXPECT_EQ(field([](M* m) { m->mutable_last_seen()->set_nanos(1'000'000'000); }),
            "last_seen.nanos");
  EXPECT_EQ(field([](M* m) { m->set_present_cells(kNan); }), "present_cells");
  EXPECT_EQ(field([](M* m) { m->set_absent_cells(-1.0); }), "absent_cells");
}

TEST(ConvertObject, GarbageIsRefusedOrReadsAsAValidState) {
  std::mt19937 random(6);
  const std::string whole = ToProto(RandomObject(&random)).SerializeAsString();
  std::uniform_int_distribution<std::size_t> place(0, whole.size() - 1);
  std::uniform_int_distribution<int> byte(0, 255);
  for (int i = 0; i < 20'000; ++i) {
    std::string damaged = whole;
    for (int flips = 0; flips < 3; ++flips)
      damaged[place(random)] = static_cast<char>(byte(random));
    v1::Object message;
    if (!message.ParseFromString(damaged)) continue;
    const absl::StatusOr<ObjectState> read = FromProto(message);
    if (!read.ok()) continue;
    EXPECT_TRUE(read->cuboid.center_world.allFinite());
    EXPECT_GT(read->belief.alpha, 0.0);
    EXPECT_LE(read->T_world_object.position_world.cwiseAbs().maxCoeff(), 10'000.0);
  }
}

}  // namespace
}  // namespace steadymap
