#include "core/geometry/geometry.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/types/error.h"
#include "tests/support/special_numbers.h"

namespace steadymap {
namespace {

using ::steadymap::testing::kNan;

PinholeCamera TorwicCamera() { return {640, 360, 461.0956, 460.9182, 325.4782, 177.5766}; }

TEST(ValidateCamera, AcceptsARealCamera) { EXPECT_TRUE(ValidateCamera(TorwicCamera()).ok()); }

TEST(ValidateCamera, NamesTheFieldThatIsWrong) {
  struct Case {
    const char* field;
    void (*spoil)(PinholeCamera&);
  };

  for (const Case& c : {Case{"width_px", [](PinholeCamera& p) { p.width_px = 0; }},
                        Case{"height_px", [](PinholeCamera& p) { p.height_px = 4097; }},
                        Case{"fx", [](PinholeCamera& p) { p.fx = 0.0; }},
                        Case{"fy", [](PinholeCamera& p) { p.fy = kNan; }},
                        Case{"cx", [](PinholeCamera& p) { p.cx = -641.0; }},
                        Case{"cy", [](PinholeCamera& p) { p.cy = kNan; }}}) {
    PinholeCamera camera = TorwicCamera();
    c.spoil(camera);
    const absl::Status status = ValidateCamera(camera);
    EXPECT_EQ(ReasonOf(status), reason::kBadIntrinsics) << status;
    EXPECT_EQ(FieldOf(status), c.field);
  }
}

TEST(MakePose, NormalisesAQuaternionThatWasRounded) {
  const absl::StatusOr<Eigen::Isometry3d> pose = MakePose({1, 2, 3}, {0, 0, 0.70711, 0.70711});
  ASSERT_TRUE(pose.ok()) << pose.status();
  EXPECT_NEAR((*pose * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(1, 3, 3)).norm(), 0.0, 1e-6);
  EXPECT_NEAR(YawOf(*pose), M_PI / 2, 1e-6);
}

TEST(MakePose, RefusesWhatIsNotAPose) {
  EXPECT_EQ(ReasonOf(MakePose({kNan, 0, 0}, {0, 0, 0, 1}).status()), reason::kNonFinitePose);
  EXPECT_EQ(ReasonOf(MakePose({1e5, 0, 0}, {0, 0, 0, 1}).status()), reason::kNonFinitePose);
  EXPECT_EQ(ReasonOf(MakePose({0, 0, 0}, {0, 0, 0, kNan}).status()), reason::kNonFinitePose);
  EXPECT_EQ(ReasonOf(MakePose({0, 0, 0}, {0, 0, 0, 0}).status()), reason::kNotARotation);
  EXPECT_EQ(ReasonOf(MakePose({0, 0, 0}, {0, 0, 1, 1}).status()), reason::kNotARotation);
}

}  // namespace
}  // namespace steadymap
