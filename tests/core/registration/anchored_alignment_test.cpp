#include "core/registration/anchored_alignment.h"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace steadymap {
namespace {

constexpr double kScaleM = 0.03;
const AlignmentPrior kClaim;

Eigen::Isometry3d Motion(const Eigen::Vector3d& shift_m, double yaw_rad) {
  return Eigen::Translation3d(shift_m) * Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ());
}

/// Returns points on the five visible sides of a box around `center_world`, seen from a robot whose
/// claimed pose is off: `motion` moves them onto the box.
AnchorMatches SeenBox(const Eigen::Vector3d& center_world, const Eigen::Isometry3d& motion) {
  AnchorMatches matches;
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> place(-0.25, 0.25);
  const Eigen::Vector3d normals[] = {Eigen::Vector3d::UnitX(),
                                     -Eigen::Vector3d::UnitX(),
                                     Eigen::Vector3d::UnitY(),
                                     -Eigen::Vector3d::UnitY(),
                                     Eigen::Vector3d::UnitZ()};
  for (const Eigen::Vector3d& normal : normals) {
    for (int i = 0; i < 40; ++i) {
      Eigen::Vector3d offset(place(random), place(random), place(random));
      offset += normal * (0.25 - normal.dot(offset));
      const Eigen::Vector3d target = center_world + offset;
      matches.push_back({motion.inverse() * target, target, normal});
    }
  }
  return matches;
}

/// Returns points on a wall along x, which does not determine a shift along itself.
AnchorMatches SeenWall(const Eigen::Isometry3d& motion) {
  AnchorMatches matches;
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> place(-3.0, 3.0);
  for (int i = 0; i < 400; ++i) {
    const Eigen::Vector3d target(place(random), 2.0, 0.3 * place(random) + 1.0);
    matches.push_back({motion.inverse() * target, target, -Eigen::Vector3d::UnitY()});
  }
  return matches;
}

/// Returns the largest distance between two motions of points within 3 m.
double Difference(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  double largest_m = 0.0;
  for (const Eigen::Vector3d& point :
       {Eigen::Vector3d(3, 0, 0), Eigen::Vector3d(-3, 0, 1), Eigen::Vector3d(0, 3, 0)}) {
    largest_m = std::max(largest_m, (a * point - b * point).norm());
  }
  return largest_m;
}

TEST(AnchoredAlignmentTest, FindsTheOffsetOfADriveThatAllThingsShare) {
  const Eigen::Isometry3d offset = Motion({0.05, -0.06, 0.02}, 0.017);
  const std::vector<AnchorMatches> anchors = {SeenBox({-1.0, 0.5, 0.25}, offset),
                                              SeenBox({1.5, 1.0, 0.25}, offset),
                                              SeenBox({0.3, 1.2, 0.25}, offset),
                                              SeenWall(offset)};
  const Eigen::Isometry3d starts[] = {offset};
  EXPECT_LT(Difference(AlignToAnchors(anchors, starts, kScaleM, kClaim).motion, offset), 0.005);
}

TEST(AnchoredAlignmentTest, DoesNotFollowTheOneThingThatMoved) {
  const Eigen::Isometry3d offset = Motion({0.03, 0.04, 0.0}, -0.01);
  const Eigen::Isometry3d moved = offset * Motion({0.1, 0.0, 0.0}, 0.0);
  const std::vector<AnchorMatches> anchors = {SeenBox({-1.0, 0.5, 0.25}, offset),
                                              SeenBox({1.5, 1.0, 0.25}, offset),
                                              SeenBox({0.3, 0.2, 0.25}, moved),
                                              SeenWall(offset)};
  const Eigen::Isometry3d starts[] = {moved, offset};
  EXPECT_LT(Difference(AlignToAnchors(anchors, starts, kScaleM, kClaim).motion, offset), 0.006);
}

TEST(AnchoredAlignmentTest, BelievesTheClaimedPoseIfOneThingAloneContradicts) {
  const Eigen::Isometry3d moved = Motion({0.05, 0.0, 0.0}, 0.0);
  const std::vector<AnchorMatches> anchors = {SeenBox({-0.4, 0.0, 0.25}, moved),
                                              SeenWall(Eigen::Isometry3d::Identity())};
  const Eigen::Isometry3d starts[] = {moved};
  const Eigen::Isometry3d motion = AlignToAnchors(anchors, starts, kScaleM, kClaim).motion;
  EXPECT_LT(Difference(motion, Eigen::Isometry3d::Identity()), 0.02);
}

TEST(AnchoredAlignmentTest, StaysWithoutAnchors) {
  const Eigen::Isometry3d motion = AlignToAnchors({}, {}, kScaleM, kClaim).motion;
  EXPECT_LT(Difference(motion, Eigen::Isometry3d::Identity()), 1e-12);
}

TEST(AnchoredAlignmentTest, CountsTheAnchorsThatAgree) {
  const Eigen::Isometry3d offset = Motion({0.03, 0.04, 0.0}, -0.01);
  const Eigen::Isometry3d moved = offset * Motion({0.1, 0.0, 0.0}, 0.0);
  const std::vector<AnchorMatches> anchors = {SeenBox({-1.0, 0.5, 0.25}, offset),
                                              SeenBox({1.5, 1.0, 0.25}, offset),
                                              SeenBox({0.3, 0.2, 0.25}, moved)};
  const Eigen::Isometry3d starts[] = {moved, offset};
  EXPECT_EQ(AlignToAnchors(anchors, starts, kScaleM, kClaim).agreeing, 2U);
  EXPECT_EQ(AlignToAnchors({}, {}, kScaleM, kClaim).agreeing, 0U);
}

TEST(AnchoredAlignmentTest, KnowsWhatTheAnchorsTell) {
  // Of five equal sides, two face along x, two along y, and one up.
  const std::vector<AnchorMatches> box = {SeenBox({1.0, 0.5, 0.25}, Motion({0, 0, 0}, 0.0))};
  const AnchorAlignment by_box = AlignToAnchors(box, {}, kScaleM, kClaim);
  EXPECT_TRUE(by_box.information.diagonal().head<3>().isApprox(Eigen::Vector3d(0.4, 0.4, 0.2)));
  EXPECT_NEAR((by_box.center_world - Eigen::Vector3d(1.0, 0.5, 0.3)).norm(), 0.0, 0.03);

  // A wall tells nothing about the shift along it, so that the prior does.
  const std::vector<AnchorMatches> wall = {SeenWall(Motion({0.0, 0.04, 0.0}, 0.0))};
  const AnchorAlignment by_wall =
      AlignToAnchors(wall, {}, kScaleM, {Motion({0.05, 0.04, 0.0}, 0.0), 1.5});
  EXPECT_NEAR(by_wall.information(0, 0), 0.0, 1e-9);
  EXPECT_NEAR(by_wall.information(1, 1), 1.0, 1e-9);
  EXPECT_LT(Difference(by_wall.motion, Motion({0.05, 0.04, 0.0}, 0.0)), 0.002);
}

TEST(AnchoredAlignmentTest, WithoutAnchorsFollowsThePrior) {
  const Eigen::Isometry3d prior = Motion({0.05, -0.02, 0.01}, 0.01);
  EXPECT_LT(Difference(AlignToAnchors({}, {}, kScaleM, {prior, 1.5}).motion, prior), 1e-9);
}

}  // namespace
}  // namespace steadymap
