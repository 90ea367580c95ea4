#include "core/objects/session_alignment.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "core/objects/surface_overlap.h"
#include "tests/support/analytic_solid.h"
#include "tests/support/default_scale.h"
#include "tests/support/object_edits.h"

namespace steadymap {
namespace {

using ::steadymap::testing::kScale;
using ::steadymap::testing::StoreVolume;

/// Returns a box of 0.5 x 0.4 x 0.6 m whose centre is at (`x_m`, `y_m`), with the space around it.
TrackedObject BoxAt(std::uint64_t id, double x_m, double y_m) {
  TrackedObject object(ObjectId(id), {x_m, y_m, 0.0}, kScale);
  const auto distance_m = [](const Eigen::Vector3d& point) {
    const Eigen::Array3d beyond = point.array().abs() - Eigen::Array3d(0.25, 0.2, 0.3);
    const double outside_m = beyond.max(0.0).matrix().norm();
    const double limit_m = kScale.truncation_m;
    return std::clamp(outside_m + std::min(beyond.maxCoeff(), 0.0), -limit_m, limit_m);
  };
  const Eigen::Vector3d reach = Eigen::Vector3d::Constant(0.8);
  StoreVolume(
      testing::MakeVolume(
          distance_m, Box(-reach, reach), kScale, [](const Eigen::Vector3d&) { return true; }),
      &object);
  return object;
}

/// Returns the offset of a session that sees three boxes, all displaced along x.
std::optional<PoseOffset> OffsetOf(double displacement_m) {
  std::vector<TrackedObject> known;
  std::vector<TrackedObject> seen;
  for (std::uint64_t i = 0; i < 3; ++i) {
    const double y_m = 2.0 * static_cast<double>(i);
    known.push_back(BoxAt(2 * i + 1, 0.0, y_m));
    seen.push_back(BoxAt(2 * i + 2, displacement_m, y_m));
  }
  return AlignSession({&seen[0], &seen[1], &seen[2]},
                      {&known[0], &known[1], &known[2]},
                      SessionIdentityParameters(),
                      kScale);
}

TEST(AlignSession, FollowsThePosesOfARobot) {
  const std::optional<PoseOffset> offset = OffsetOf(0.08);
  ASSERT_TRUE(offset.has_value());
  EXPECT_EQ(offset->anchors, 3U);
  EXPECT_NEAR(offset->shift_world.x(), -0.08, 0.01);
  EXPECT_NEAR(offset->yaw_rad, 0.0, 0.01);
  EXPECT_NEAR(offset->center_world.y(), 2.0, 0.05);
  const Eigen::Vector3d point = Eigen::Vector3d(0.08, 4.0, 0.1);
  EXPECT_LT((offset->ToIsometry() * point - Eigen::Vector3d(0.0, 4.0, 0.1)).norm(), 0.02);
  // The offset is known better than without objects, but not better than three of them allow.
  const Eigen::Matrix4d& covariance = offset->covariance;
  EXPECT_EQ(covariance, covariance.transpose().eval());
  for (int i = 0; i < 3; ++i) {
    EXPECT_LT(std::sqrt(covariance(i, i)), 0.05) << i;
    EXPECT_GT(std::sqrt(covariance(i, i)), 0.02 / std::sqrt(3.0)) << i;
  }
}

TEST(AlignSession, ThingsThatMovedAlikeAreNoPoseError) {
  const double limit_m = SessionIdentityParameters().max_session_offset_m;
  for (const double displacement_m : {1.3 * limit_m, 1.6 * limit_m, 1.9 * limit_m}) {
    EXPECT_EQ(OffsetOf(displacement_m), std::nullopt) << displacement_m;
  }
}

TEST(FitsAtRest, TellsADisplacementThatTheSurfaceShows) {
  const TrackedObject known = BoxAt(std::uint64_t{1}, 0.0, 0.0);
  for (const double displacement_m : {0.03, 0.06, 0.1}) {
    const TrackedObject seen = BoxAt(std::uint64_t{2}, displacement_m, 0.0);
    const Registration registration = *RegisterToKnown(seen, known, kScale);
    EXPECT_FALSE(FitsAtRest(registration, SessionIdentityParameters(), kScale)) << displacement_m;
  }
}

TEST(FitsAtRest, NeedsEnoughKnownSurface) {
  const SessionIdentityParameters parameters;
  Registration registration;
  registration.known_loss = 0.03;
  registration.known_loss_at_rest = 0.01;
  registration.known_share_at_rest = 0.9 * parameters.parts.shares.substantial;
  EXPECT_FALSE(FitsAtRest(registration, parameters, kScale));
  registration.known_share_at_rest = 1.1 * parameters.parts.shares.substantial;
  EXPECT_TRUE(FitsAtRest(registration, parameters, kScale));
  registration.known_loss_at_rest = 0.08;
  EXPECT_FALSE(FitsAtRest(registration, parameters, kScale));
}

TEST(FitsAtRest, ACorrectionWithinTheErrorOfTwoLooksTellsNothing) {
  const SessionIdentityParameters parameters;
  for (const double voxel_m : {0.02, 0.05, 0.1}) {
    const VoxelScale scale{voxel_m, DefaultTruncationM(voxel_m)};
    const double sigma_m = SurfaceSigmaM(parameters.parts.surface, scale);
    Registration registration;
    registration.known_share_at_rest = 1.0;
    registration.known_loss = 0.01;
    for (const double sigmas : {0.9, 1.1}) {
      const double voxels = sigmas * sigma_m / voxel_m;
      registration.known_loss_at_rest = 0.01 + voxels * voxels;
      EXPECT_EQ(FitsAtRest(registration, parameters, scale), sigmas < 1.0) << voxel_m;
    }
  }
}

TEST(FitsAtRest, ACorrectionOfNoisySurfaceMustExplainMostOfItsDistances) {
  Registration registration;
  registration.known_share_at_rest = 1.0;
  registration.known_loss = 0.2;
  registration.known_loss_at_rest = 0.35;
  EXPECT_TRUE(FitsAtRest(registration, SessionIdentityParameters(), kScale));
  registration.known_loss_at_rest = 0.45;
  EXPECT_FALSE(FitsAtRest(registration, SessionIdentityParameters(), kScale));
}

TEST(IsDisplaced, NeedsACorrectionThatBringsMoreOfTheSurfaceClose) {
  const SessionIdentityParameters parameters;
  const TrackedObject known = BoxAt(std::uint64_t{1}, 0.0, 0.0);
  for (const double displacement_m : {0.0, 0.06}) {
    const TrackedObject seen = BoxAt(std::uint64_t{2}, displacement_m, 0.0);
    for (const double correction_m : {0.0, -0.06, 0.06}) {
      Registration registration;  // Knows no surface at rest, so that `FitsAtRest` is false.
      registration.T_correction.translation().x() = correction_m;
      registration.shift_world.x() = correction_m;
      EXPECT_EQ(IsDisplaced(registration, seen, known, parameters, kScale),
                displacement_m > 0.0 && correction_m < 0.0)
          << displacement_m << " " << correction_m;
    }
  }
}

TEST(IsDisplaced, FollowsTheCorrectionIfHardlyAnySurfaceIsCloseAtRest) {
  const TrackedObject known = BoxAt(std::uint64_t{1}, 0.0, 0.0);
  const TrackedObject seen = BoxAt(std::uint64_t{2}, 2.0, 0.0);
  Registration registration;
  registration.shift_world.x() = 0.06;
  EXPECT_TRUE(IsDisplaced(registration, seen, known, SessionIdentityParameters(), kScale));
}

}  // namespace
}  // namespace steadymap
