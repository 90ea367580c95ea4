// Registers the points of one view of an object, moved by known motions, to the object surface.

#include "core/registration/icp.h"

#include <cmath>
#include <limits>
#include <random>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/analytic_solid.h"
#include "tests/support/default_scale.h"
#include "tests/support/object_edits.h"

namespace steadymap {
namespace {

using ::steadymap::testing::CrateWithParcel;
using ::steadymap::testing::kScale;
using ::steadymap::testing::LooksAround;
using ::steadymap::testing::MakeVolume;
using ::steadymap::testing::RandomMotionAbout;
using ::steadymap::testing::Solid;
using ::steadymap::testing::StoreVolume;
using ::steadymap::testing::SurfaceView;
using ::steadymap::testing::ThingsToLookAt;
using ::steadymap::testing::WithNoise;

constexpr double kIcpSpacingRad = 0.02;
constexpr double kIcpNoiseM = 0.003;

/// Returns an object whose frame is the world frame translated by `position_world`.
TrackedObject Thing(const Solid& solid, const Eigen::Vector3d& position_world) {
  TrackedObject thing(ObjectId(1), position_world, kScale);
  StoreVolume(MakeVolume(solid, kScale), &thing);
  return thing;
}

double MeanError(const std::vector<Eigen::Vector3d>& points,
                 const Eigen::Isometry3d& correction,
                 const Eigen::Isometry3d& motion) {
  double sum_m = 0.0;
  for (const Eigen::Vector3d& point : points) sum_m += (correction * motion * point - point).norm();
  return sum_m / static_cast<double>(points.size());
}

TEST(IcpTarget, RecoversMostKnownMotions) {
  constexpr int kMotionsOfASolid = 100;
  constexpr double kRecoveredM = 0.02;
  std::mt19937_64 random(1);
  int recovered = 0;
  int motions = 0;
  for (const Solid& solid : ThingsToLookAt()) {
    const std::vector<SurfaceView> views = LooksAround(solid, kIcpSpacingRad);
    IcpTarget target(Thing(solid, Eigen::Vector3d::Zero()));
    for (int i = 0; i < kMotionsOfASolid; ++i) {
      const std::vector<Eigen::Vector3d> points =
          WithNoise(views[static_cast<std::size_t>(i) % views.size()], kIcpNoiseM, &random);
      const Eigen::Isometry3d motion = RandomMotionAbout({0.0, 0.0, 0.4}, &random);
      std::vector<Eigen::Vector3d> moved = points;
      for (Eigen::Vector3d& point : moved) point = motion * point;
      const IcpFit fit = target.Align(moved);
      ++motions;
      if (MeanError(points, fit.T_correction, motion) > kRecoveredM) continue;
      ++recovered;
      EXPECT_LT(fit.outlier_share, 0.02);
      EXPECT_NEAR(fit.yaw_rad, -std::atan2(motion(1, 0), motion(0, 0)), 0.05);
    }
  }
  RecordProperty("recovered", recovered);
  EXPECT_GE(recovered, motions * 8 / 10);
}

TEST(IcpTarget, SaysHowFarTheCentroidMoves) {
  const SurfaceView view = LooksAround(CrateWithParcel(), kIcpSpacingRad).front();
  IcpTarget target(Thing(CrateWithParcel(), Eigen::Vector3d::Zero()));
  const Eigen::Vector3d shift(0.04, -0.03, 0.02);
  std::vector<Eigen::Vector3d> points = view.points;
  for (Eigen::Vector3d& point : points) point += shift;
  const IcpFit fit = target.Align(points);
  EXPECT_LT((fit.shift_world + shift).norm(), 0.02);
  EXPECT_NEAR(fit.yaw_rad, 0.0, 0.02);
}

TEST(IcpTarget, IsAsGoodFarFromTheOriginOfTheWorld) {
  const Eigen::Vector3d far_world(5000.0, -3000.0, 10.0);
  const SurfaceView view = LooksAround(CrateWithParcel(), kIcpSpacingRad).front();
  IcpTarget near(Thing(CrateWithParcel(), Eigen::Vector3d::Zero()));
  IcpTarget far(Thing(CrateWithParcel(), far_world));
  const Eigen::Vector3d shift(0.05, 0.02, 0.0);
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector3d> points_far;
  for (const Eigen::Vector3d& point : view.points) {
    points.emplace_back(point + shift);
    points_far.emplace_back(far_world + point + shift);
  }
  const IcpFit fit = near.Align(points);
  const IcpFit fit_far = far.Align(points_far);
  EXPECT_LT((fit.shift_world - fit_far.shift_world).norm(), 1e-3);
  const Eigen::Vector3d corrected = fit.T_correction * points.front();
  const Eigen::Vector3d corrected_far = fit_far.T_correction * points_far.front() - far_world;
  EXPECT_LT((corrected - corrected_far).norm(), 2e-3);
}

// All normals are parallel, so the motion along the wall is unobservable: it must be zero, not NaN.
TEST(IcpTarget, DoesNotMoveAlongAPlane) {
  const Solid wall = {Box(Eigen::Vector3d(1.0, -1.5, 0.0), Eigen::Vector3d(1.3, 1.5, 2.0))};
  IcpTarget target(Thing(wall, Eigen::Vector3d::Zero()));
  std::vector<Eigen::Vector3d> points;
  for (int column = -16; column <= 16; ++column) {
    for (int row = 10; row <= 30; ++row) points.emplace_back(0.95, 0.05 * column, 0.05 * row);
  }
  const IcpFit fit = target.Align(points);
  EXPECT_LT((fit.shift_world - Eigen::Vector3d(0.05, 0.0, 0.0)).norm(), 0.01);
  EXPECT_NEAR(fit.yaw_rad, 0.0, 0.01);
  EXPECT_LT(fit.outlier_share, 0.01);
}

TEST(IcpTarget, WhatIsNotMappedIsAnOutlier) {
  const Solid lower = {CrateWithParcel().front()};
  IcpTarget target(Thing(lower, Eigen::Vector3d::Zero()));
  const SurfaceView view = LooksAround(CrateWithParcel(), kIcpSpacingRad).front();
  EXPECT_GT(target.Align(view.points).outlier_share, 0.1);
}

TEST(IcpTarget, FitsNothingThatIsElsewhere) {
  IcpTarget target(Thing(CrateWithParcel(), Eigen::Vector3d::Zero()));
  std::vector<Eigen::Vector3d> points =
      LooksAround(CrateWithParcel(), kIcpSpacingRad).front().points;
  for (Eigen::Vector3d& point : points) point.x() += 3.0;
  const IcpFit fit = target.Align(points);
  EXPECT_EQ(fit.outlier_share, 1.0);
  EXPECT_TRUE(fit.T_correction.isApprox(Eigen::Isometry3d::Identity()));
}

TEST(IcpTarget, FitsNothingOfTooFewPoints) {
  IcpTarget target(Thing(CrateWithParcel(), Eigen::Vector3d::Zero()));
  IcpTarget empty(TrackedObject(ObjectId(2), Eigen::Vector3d::Zero(), kScale));
  const std::vector<Eigen::Vector3d> points =
      LooksAround(CrateWithParcel(), kIcpSpacingRad).front().points;
  EXPECT_EQ(target.Align({}).outlier_share, 1.0);
  EXPECT_EQ(target.Align(std::span(points).first(9)).outlier_share, 1.0);
  EXPECT_EQ(empty.Align(points).outlier_share, 1.0);
}

TEST(IcpTarget, LeavesOutPointsThatAreNotFinite) {
  IcpTarget target(Thing(CrateWithParcel(), Eigen::Vector3d::Zero()));
  std::vector<Eigen::Vector3d> points =
      LooksAround(CrateWithParcel(), kIcpSpacingRad).front().points;
  points[1].setConstant(std::nan(""));
  points[4].x() = std::numeric_limits<double>::infinity();
  EXPECT_LT(target.Align(points).outlier_share, 0.02);
}

}  // namespace
}  // namespace steadymap
