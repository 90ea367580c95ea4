#include "server/mapping/capture_clocks.h"

#include <chrono>
#include <cstdint>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "core/types/error.h"

namespace steadymap {
namespace {

const SensorName kCamera{"robot-1", "camera"};
constexpr double kNowS = 1.7e9;

Timestamp At(double seconds) { return Timestamp::FromSeconds(seconds); }

TEST(CaptureClocks, KnowHowFarEachSensorIsAhead) {
  CaptureClocks clocks("m");
  const SensorName other{"robot-1", "left"};
  EXPECT_FALSE(clocks.AheadOf(kCamera).has_value());
  EXPECT_TRUE(clocks.Note(kCamera, At(kNowS + 3.0), v1::CLOCK_DOMAIN_ROBOT, At(kNowS)).ok());
  EXPECT_TRUE(clocks.Note(other, At(kNowS - 60.0), v1::CLOCK_DOMAIN_UTC, At(kNowS)).ok());
  EXPECT_EQ(clocks.AheadOf(kCamera), std::chrono::seconds(3));
  EXPECT_EQ(clocks.AheadOf(other), std::chrono::seconds(-60));
}

TEST(CaptureClocks, RefuseAFrameOfTheDayAfterTomorrow) {
  CaptureClocks clocks("m");
  const double limit_s = std::chrono::duration<double>(CaptureClocks::kMaxAhead).count();
  EXPECT_TRUE(clocks.Note(kCamera, At(kNowS + limit_s), v1::CLOCK_DOMAIN_UTC, At(kNowS)).ok());
  const absl::Status status =
      clocks.Note(kCamera, At(kNowS + limit_s + 1.0), v1::CLOCK_DOMAIN_UTC, At(kNowS));
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(ReasonOf(status), reason::kBadCaptureTime);
  EXPECT_EQ(FieldOf(status), "capture_time");
  EXPECT_EQ(clocks.AheadOf(kCamera), CaptureClocks::kMaxAhead) << "of the newest one taken";
}

TEST(CaptureClocks, TakeRecordingsOfAnyTime) {
  CaptureClocks clocks("m");
  for (const std::int64_t ns : {std::numeric_limits<std::int64_t>::min(),
                                std::int64_t{0},
                                std::numeric_limits<std::int64_t>::max()}) {
    EXPECT_TRUE(
        clocks.Note(kCamera, Timestamp::FromNanoseconds(ns), v1::CLOCK_DOMAIN_RECORDING, At(kNowS))
            .ok());
  }
}

TEST(CaptureClocks, ForgetTheSensorThatWasHeardOfLongestAgo) {
  CaptureClocks clocks("m");
  const auto sensor = [](std::size_t i) {
    return SensorName{"robot-" + std::to_string(i), "left"};
  };
  const auto note = [&](const SensorName& name) {
    EXPECT_TRUE(clocks.Note(name, At(kNowS), v1::CLOCK_DOMAIN_UTC, At(kNowS)).ok());
  };
  for (std::size_t i = 0; i < CaptureClocks::kMaxSensors; ++i) note(sensor(i));
  note(sensor(0));
  note(kCamera);
  EXPECT_TRUE(clocks.AheadOf(kCamera).has_value());
  EXPECT_TRUE(clocks.AheadOf(sensor(0)).has_value());
  EXPECT_FALSE(clocks.AheadOf(sensor(1)).has_value());
  EXPECT_TRUE(clocks.AheadOf(sensor(2)).has_value());
}

TEST(CaptureClocks, AServerWithoutAClockRefusesNobody) {
  CaptureClocks clocks("m");
  EXPECT_TRUE(clocks.Note(kCamera, At(kNowS), v1::CLOCK_DOMAIN_UTC, At(5.0)).ok());
}

}  // namespace
}  // namespace steadymap
