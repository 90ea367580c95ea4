#include "proto/convert_robot.h"

#include <gtest/gtest.h>

namespace steadymap {
namespace {

TEST(ConvertRobot, StatesTrustPoseSessionAndOffset) {
  RobotState state;
  state.trust = Trust::kLost;
  state.last_capture_time = Timestamp::FromSeconds(102.5);
  state.claimed.position_world = {1.0, 2.0, 3.0};
  state.claimed.rotation_world = {0.0F, 0.0F, 3.14159265F};
  state.session_start = Timestamp::FromSeconds(100.0);
  PoseOffset offset;
  offset.time = Timestamp::FromSeconds(90.0);
  offset.center_world = {4.0, 5.0, 6.0};
  offset.shift_world = {0.01, -0.02, 0.03};
  offset.yaw_rad = 0.004;
  offset.covariance(1, 2) = 7.0;
  offset.anchors = 8;
  state.offset = offset;
  PoseErrorEstimate error{Timestamp::FromSeconds(102.0), {}};
  error.hypotheses[0].probability = 1.0;
  error.hypotheses[1].probability = error.hypotheses[2].probability = 0.0;
  error.hypotheses[0].error.mean << 0.1, 0.2, 0.3, 0.4, 0.5, 0.6;
  error.hypotheses[0].error.covariance(1, 2) = 9.0;
  state.pose_error = error;

  const v1::Robot robot = ToProto(SensorName{"dolly", "left"}, state);
  EXPECT_EQ(robot.robot(), "dolly");
  EXPECT_EQ(robot.sensor(), "left");
  EXPECT_EQ(robot.trust(), v1::ROBOT_TRUST_LOST);
  EXPECT_EQ(robot.last_capture_time().nanos(), 500'000'000);
  EXPECT_EQ(robot.world_from_camera().position_m().y(), 2.0);
  EXPECT_NEAR(robot.world_from_camera().orientation().z(), 1.0, 1e-6);
  EXPECT_EQ(robot.session_start().seconds(), 100);
  EXPECT_EQ(robot.pose_offset().time().seconds(), 90);
  EXPECT_EQ(robot.pose_offset().center_m().z(), 6.0);
  EXPECT_EQ(robot.pose_offset().shift_m().y(), -0.02);
  EXPECT_EQ(robot.pose_offset().yaw_rad(), 0.004);
  ASSERT_EQ(robot.pose_offset().covariance_size(), 16);
  EXPECT_EQ(robot.pose_offset().covariance(6), 7.0) << "row 1, column 2";
  EXPECT_EQ(robot.pose_offset().anchors(), 8U);
  EXPECT_EQ(robot.pose_error().time().seconds(), 102);
  EXPECT_EQ(robot.pose_error().shift_m().y(), 0.2);
  EXPECT_EQ(robot.pose_error().rotation_rad().z(), 0.6);
  ASSERT_EQ(robot.pose_error().covariance_size(), 36);
  EXPECT_EQ(robot.pose_error().covariance(8), 9.0) << "row 1, column 2";
}

TEST(ConvertRobot, StatesWithWhomItDisagrees) {
  const v1::SensorContradiction message =
      ToProto(SensorContradiction{{"dolly", "left"}, 3, Timestamp::FromSeconds(7.5)});
  EXPECT_EQ(message.robot(), "dolly");
  EXPECT_EQ(message.sensor(), "left");
  EXPECT_EQ(message.objects(), 3U);
  EXPECT_EQ(message.since().nanos(), 500'000'000);
}

TEST(ConvertRobot, StatesNothingThatIsUnknown) {
  const v1::Robot robot = ToProto(SensorName{"dolly", "left"}, RobotState());
  EXPECT_EQ(robot.trust(), v1::ROBOT_TRUST_TRUSTED);
  EXPECT_FALSE(robot.has_session_start());
  EXPECT_FALSE(robot.has_pose_offset());
  EXPECT_FALSE(robot.has_pose_error());
}

}  // namespace
}  // namespace steadymap
