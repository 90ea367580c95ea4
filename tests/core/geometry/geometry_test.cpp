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

TEST(PinholeCamera, ProjectsTheRayOfAPixelToThatPixel) {
  const PinholeCamera camera = TorwicCamera();
  for (const double depth_m : {0.05, 1.0, 80.0}) {
    for (const double u : {-3.0, 0.0, 320.5, 639.0}) {
      const Eigen::Vector3d point_camera = depth_m * camera.Ray(u, 0.25 * u);
      EXPECT_NEAR((camera.Project(point_camera) - Eigen::Vector2d(u, 0.25 * u)).norm(), 0.0, 1e-9);
      const Eigen::Vector3f coarse = point_camera.cast<float>();
      EXPECT_NEAR(camera.Project(coarse).x(), static_cast<float>(u), 1e-3F);
    }
  }
}

TEST(PinholeCamera, ContainsHalfAPixelAroundItsPixelCentres) {
  const PinholeCamera camera = TorwicCamera();
  EXPECT_TRUE(camera.Contains(Eigen::Vector2d(-0.5, -0.5)));
  EXPECT_TRUE(camera.Contains(Eigen::Vector2d(639.4, 359.4)));
  EXPECT_FALSE(camera.Contains(Eigen::Vector2d(-0.6, 0.0)));
  EXPECT_FALSE(camera.Contains(Eigen::Vector2d(0.0, -0.6)));
  EXPECT_FALSE(camera.Contains(Eigen::Vector2d(639.5, 0.0)));
  EXPECT_FALSE(camera.Contains(Eigen::Vector2d(0.0, 359.5)));
  EXPECT_FALSE(camera.Contains(Eigen::Vector2d(kNan, 0.0)));
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
