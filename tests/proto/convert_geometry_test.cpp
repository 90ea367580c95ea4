#include "proto/convert_geometry.h"

#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "core/types/error.h"
#include "tests/support/special_numbers.h"

namespace steadymap {
namespace {

using ::steadymap::testing::kInfinity;
using ::steadymap::testing::kNan;

// Rounding error of a rotation after the conversion to a quaternion and back.
constexpr double kRotationTolerance = 1e-12;

TEST(ConvertPose, RandomPosesComeBack) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector4d q(normal(random), normal(random), normal(random), normal(random));
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = Eigen::Quaterniond(q.normalized()).toRotationMatrix();
    pose.translation() = 100.0 * Eigen::Vector3d(normal(random), normal(random), normal(random));
    const auto back = FromProto(ToProto(pose));
    ASSERT_TRUE(back.ok()) << back.status();
    EXPECT_TRUE(back->isApprox(pose, kRotationTolerance));
  }
}

TEST(ConvertPose, AbsentAndNonFinitePartsAreNamed) {
  const v1::Pose good = ToProto(Eigen::Isometry3d::Identity());
  v1::Pose pose = good;
  pose.clear_position_m();
  EXPECT_EQ(FieldOf(FromProto(pose).status()), "position_m");
  pose = good;
  pose.clear_orientation();
  EXPECT_EQ(ReasonOf(FromProto(pose).status()), "NOT_A_ROTATION");
  for (const double bad : {kNan, kInfinity, -kInfinity}) {
    pose = good;
    pose.mutable_position_m()->set_y(bad);
    EXPECT_EQ(ReasonOf(FromProto(pose).status()), "NON_FINITE_POSE");
    pose = good;
    pose.mutable_orientation()->set_x(bad);
    EXPECT_EQ(ReasonOf(FromProto(pose).status()), "NON_FINITE_POSE");
    EXPECT_EQ(FieldOf(FromProto(pose).status()), "orientation");
  }
}

TEST(ConvertBox, ComesBack) {
  const Box box(Eigen::Vector3d(-1, 2, 3), Eigen::Vector3d(4, 2, 6));
  const auto back = FromProto(ToProto(box));
  ASSERT_TRUE(back.ok());
  EXPECT_EQ(back->min(), box.min());
  EXPECT_EQ(back->max(), box.max());
}

TEST(ConvertBox, WrongCornersAreNamed) {
  const v1::Box good = ToProto(Box(Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 1, 1)));
  v1::Box box = good;
  box.clear_min_m();
  EXPECT_EQ(FieldOf(FromProto(box).status()), "min_m");
  box = good;
  box.clear_max_m();
  EXPECT_EQ(FieldOf(FromProto(box).status()), "max_m");
  box = good;
  box.mutable_max_m()->set_z(-0.1);
  EXPECT_EQ(FieldOf(FromProto(box).status()), "max_m");
  box = good;
  box.mutable_min_m()->set_x(kNan);
  EXPECT_EQ(FieldOf(FromProto(box).status()), "min_m");
}

TEST(ConvertTimestamp, ComesBackToTheNanosecond) {
  for (const std::int64_t ns : {std::int64_t{0},
                                std::int64_t{1},
                                std::int64_t{999'999'999},
                                std::int64_t{1'700'000'000'123'456'789}}) {
    EXPECT_EQ(*FromProto(ToProto(Timestamp::FromNanoseconds(ns))), Timestamp::FromNanoseconds(ns));
  }
}

TEST(ConvertTimestamp, MomentsOutOfRangeAreRefused) {
  const auto field = [](std::int64_t seconds, std::int32_t nanos) {
    google::protobuf::Timestamp time;
    time.set_seconds(seconds);
    time.set_nanos(nanos);
    const auto status = FromProto(time).status();
    EXPECT_EQ(ReasonOf(status), "BAD_TIMESTAMP");
    return FieldOf(status);
  };
  EXPECT_EQ(field(-1, 0), "seconds");
  EXPECT_EQ(field(std::numeric_limits<std::int64_t>::max(), 0), "seconds");
  EXPECT_EQ(field(std::numeric_limits<std::int64_t>::min(), 0), "seconds");
  EXPECT_EQ(field(9'223'372'036, 0), "seconds");
  EXPECT_EQ(field(1, -1), "nanos");
  EXPECT_EQ(field(1, 1'000'000'000), "nanos");
}

}  // namespace
}  // namespace steadymap
