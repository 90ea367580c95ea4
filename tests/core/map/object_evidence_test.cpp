#include "core/map/object_evidence.h"

#include <algorithm>
#include <string>

#include <gtest/gtest.h>

namespace steadymap {
namespace {

SensorName SensorOf(std::size_t robot) { return {"robot-" + std::to_string(robot), "camera"}; }

std::vector<LeafEvidence> LookAt(double time_s) {
  return {{{0, 0, 0}, {}, Timestamp::FromSeconds(time_s - 1.0)},
          {{8, 0, 0}, {}, Timestamp::FromSeconds(time_s)}};
}

TEST(SessionLooks, AreKeptBySource) {
  std::vector<SessionLooks> looks;
  for (const std::size_t robot : {2U, 1U, 3U}) {
    StoreLooks(SensorOf(robot), LookAt(10.0 * static_cast<double>(robot)), &looks);
  }
  ASSERT_EQ(looks.size(), 3U);
  for (std::size_t i = 0; i < looks.size(); ++i) EXPECT_EQ(looks[i].source, SensorOf(i + 1));
  EXPECT_EQ(LastLook(looks[1].leaves), Timestamp::FromSeconds(20.0));
  EXPECT_EQ(LastLook({}), Timestamp());
  EXPECT_EQ(TakeLooks(SensorOf(2), &looks), LookAt(20.0));
  EXPECT_TRUE(TakeLooks(SensorOf(2), &looks).empty());
  EXPECT_EQ(looks.size(), 2U);
}

TEST(SessionLooks, OfTooManySessionsThoseWithTheOldestLooksAreDropped) {
  std::vector<SessionLooks> looks;
  for (std::size_t robot = 0; robot < kMaxLookingSessions; ++robot) {
    StoreLooks(SensorOf(robot), LookAt(robot == 3 ? 5.0 : 100.0), &looks);
  }
  StoreLooks({"late", "camera"}, LookAt(200.0), &looks);
  EXPECT_EQ(looks.size(), kMaxLookingSessions);
  EXPECT_TRUE(TakeLooks(SensorOf(3), &looks).empty());
  EXPECT_FALSE(TakeLooks({"late", "camera"}, &looks).empty());
}

}  // namespace
}  // namespace steadymap
