// Oracles: closed forms, and random or densely spaced points of the boxes.

#include "core/geometry/cuboid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace steadymap {
namespace {

constexpr double kPi = std::numbers::pi;

Cuboid CubeAt(double x, double y, double z, double side_m, double yaw_rad = 0.0) {
  return {{x, y, z}, {side_m, side_m, side_m}, yaw_rad};
}

Cuboid RandomCuboid(std::mt19937* random) {
  std::uniform_real_distribution<double> place(-1.5, 1.5);
  std::uniform_real_distribution<double> size(0.05, 2.5);
  std::uniform_real_distribution<double> yaw(-kPi, kPi);
  return {{place(*random), place(*random), place(*random)},
          {size(*random), size(*random), size(*random)},
          yaw(*random)};
}

/// Returns the point of the box at normalised coordinates `unit` in [-1, 1].
Eigen::Vector3d PointIn(const Cuboid& cuboid, const Eigen::Vector3d& unit) {
  return cuboid.T_world_cuboid() * (0.5 * unit.cwiseProduct(cuboid.size_m));
}

/// Whether the box contains a point, computed from the half-spaces of the sides of its base.
bool Contains(const Cuboid& cuboid, const Eigen::Vector3d& point_world) {
  if (point_world.z() < cuboid.lowest_m() || point_world.z() > cuboid.highest_m()) return false;
  const std::array<Eigen::Vector2d, 4> corners = cuboid.BaseCorners();
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d side = corners[(i + 1) % 4] - corners[i];
    const Eigen::Vector2d offset = point_world.head<2>() - corners[i];
    if (side.x() * offset.y() - side.y() * offset.x() < 0.0) return false;
  }
  return true;
}

/// Returns the minimum distance between `a` and `b`, by alternating projection (a convex problem).
double ProjectedDistance(const Cuboid& a, const Cuboid& b) {
  const auto project = [](const Cuboid& cuboid, const Eigen::Vector3d& point_world) {
    const Eigen::Vector3d half_m = 0.5 * cuboid.size_m;
    const Eigen::Vector3d local = cuboid.T_world_cuboid().inverse() * point_world;
    return Eigen::Vector3d(cuboid.T_world_cuboid() * local.cwiseMax(-half_m).cwiseMin(half_m));
  };
  Eigen::Vector3d in_a = a.center_world;
  Eigen::Vector3d in_b = b.center_world;
  for (int step = 0; step < 3000; ++step) {
    in_b = project(b, in_a);
    in_a = project(a, in_b);
  }
  return (in_a - in_b).norm();
}

TEST(Cuboid, CornersRunCounterClockwiseAndLieInItsFrame) {
  const Cuboid cuboid{{1.0, 2.0, 3.0}, {4.0, 2.0, 1.0}, kPi / 2};
  const std::array<Eigen::Vector2d, 4> corners = cuboid.BaseCorners();
  EXPECT_TRUE(corners[0].isApprox(Eigen::Vector2d(2.0, 0.0)));
  EXPECT_TRUE(corners[1].isApprox(Eigen::Vector2d(2.0, 4.0)));
  EXPECT_TRUE(corners[2].isApprox(Eigen::Vector2d(0.0, 4.0), 1e-12));
  EXPECT_NEAR((corners[3] - Eigen::Vector2d(0.0, 0.0)).norm(), 0.0, 1e-12);
  EXPECT_TRUE((PointIn(cuboid, {-1, -1, 0}).head<2>().isApprox(corners[0])));
  EXPECT_DOUBLE_EQ(cuboid.lowest_m(), 2.5);
  EXPECT_DOUBLE_EQ(cuboid.highest_m(), 3.5);
  EXPECT_DOUBLE_EQ(cuboid.volume_m3(), 8.0);
}

TEST(DistanceTo, FaceEdgeAndCornerOfATurnedCube) {
  const Cuboid cube = CubeAt(1.0, 1.0, 1.0, 2.0, kPi / 4);
  const double half_diagonal_m = std::sqrt(2.0);
  EXPECT_DOUBLE_EQ(DistanceTo(cube, {1.0, 1.0, 1.0}), 0.0);
  EXPECT_NEAR(DistanceTo(cube, {1.0, 1.0, 5.0}), 3.0, 1e-12);
  EXPECT_NEAR(DistanceTo(cube, {1.0 + half_diagonal_m + 3.0, 1.0, 1.0}), 3.0, 1e-12);
  EXPECT_NEAR(DistanceTo(cube, {1.0 + half_diagonal_m + 3.0, 1.0, -4.0}), 5.0, 1e-12);
  EXPECT_NEAR(DistanceTo(cube, {3.0, 3.0, 1.0}), 2.0 * std::sqrt(2.0) - 1.0, 1e-12);
}

TEST(DistanceBetween, ClosedForms) {
  EXPECT_DOUBLE_EQ(DistanceBetween(CubeAt(0, 0, 0, 1), CubeAt(3, 0, 0, 1)), 2.0);
  EXPECT_DOUBLE_EQ(DistanceBetween(CubeAt(0, 0, 0, 1), CubeAt(4, 5, 0, 1)), 5.0);
  EXPECT_DOUBLE_EQ(DistanceBetween(CubeAt(0, 0, 0, 1), CubeAt(4, 0, 5, 1)), 5.0);
  EXPECT_DOUBLE_EQ(DistanceBetween(CubeAt(0, 0, 0, 1), CubeAt(1, 0, 0, 1)), 0.0);
  EXPECT_DOUBLE_EQ(DistanceBetween(CubeAt(0, 0, 0, 9), CubeAt(1, 1, 1, 1, 0.7)), 0.0);
  EXPECT_NEAR(DistanceBetween(CubeAt(0, 0, 0, 2), CubeAt(5, 0, 0, 2, kPi / 4)),
              4.0 - std::sqrt(2.0),
              1e-12);
}

TEST(DistanceBetween, BoxesThatCrossWithoutACornerInsideTouch) {
  const Cuboid wall{{0, 0, 0}, {4.0, 0.1, 1.0}, 0.3};
  const Cuboid other{{0, 0, 0}, {4.0, 0.1, 1.0}, 1.3};
  EXPECT_DOUBLE_EQ(DistanceBetween(wall, other), 0.0);
}

TEST(DistanceBetween, BoxesWithoutThickness) {
  const Cuboid point{{3.0, 4.0, 12.0}, Eigen::Vector3d::Zero(), 0.4};
  const Cuboid origin;
  EXPECT_DOUBLE_EQ(DistanceBetween(point, origin), 13.0);
  EXPECT_DOUBLE_EQ(DistanceBetween(point, point), 0.0);
  const Cuboid line{{0, 0, 0}, {2.0, 0.0, 0.0}, 0.0};
  const Cuboid crossing{{0.5, 0, 0}, {2.0, 0.0, 0.0}, 1.0};
  const Cuboid beside{{0, 0.5, 0}, {2.0, 0.0, 0.0}, 0.0};
  const Cuboid behind{{2.5, 0, 0}, {2.0, 0.0, 0.0}, 0.0};
  EXPECT_DOUBLE_EQ(DistanceBetween(line, crossing), 0.0);
  EXPECT_DOUBLE_EQ(DistanceBetween(line, beside), 0.5);
  EXPECT_DOUBLE_EQ(DistanceBetween(line, behind), 0.5);
}

TEST(DistanceBetween, AgreesWithTheLimitOfProjections) {
  std::mt19937 random(1);
  int apart = 0;
  for (int round = 0; round < 200; ++round) {
    const Cuboid a = RandomCuboid(&random);
    const Cuboid b = RandomCuboid(&random);
    const double distance_m = DistanceBetween(a, b);
    ASSERT_NEAR(distance_m, ProjectedDistance(a, b), 1e-3) << "round " << round;
    ASSERT_NEAR(distance_m, DistanceBetween(b, a), 1e-12);
    if (distance_m > 0.0) ++apart;
  }
  EXPECT_GT(apart, 50);
  EXPECT_LT(apart, 150);
}

TEST(OverlapM3, ClosedForms) {
  EXPECT_NEAR(OverlapM3(CubeAt(0, 0, 0, 2), CubeAt(0, 0, 0, 2)), 8.0, 1e-12);
  EXPECT_NEAR(OverlapM3(CubeAt(0, 0, 0, 2), CubeAt(1.5, 1, -1.75, 2)), 0.125, 1e-12);
  EXPECT_NEAR(OverlapM3(CubeAt(0, 0, 0, 9), CubeAt(1, 1, 1, 1, 0.7)), 1.0, 1e-12);
  // Two unit squares at 45 degrees intersect in a regular octagon of area 2 (sqrt(2) - 1).
  EXPECT_NEAR(OverlapM3(CubeAt(0, 0, 0, 1), CubeAt(0, 0, 0, 1, kPi / 4)),
              2.0 * (std::sqrt(2.0) - 1.0),
              1e-12);
}

TEST(OverlapM3, NothingSharedByBoxesThatAreApartTouchOrHaveNoThickness) {
  EXPECT_DOUBLE_EQ(OverlapM3(CubeAt(0, 0, 0, 1), CubeAt(3, 0, 0, 1, 0.5)), 0.0);
  EXPECT_DOUBLE_EQ(OverlapM3(CubeAt(0, 0, 0, 1), CubeAt(0, 0, 3, 1, 0.5)), 0.0);
  EXPECT_DOUBLE_EQ(OverlapM3(CubeAt(0, 0, 0, 1), CubeAt(1, 0, 0, 1)), 0.0);
  EXPECT_DOUBLE_EQ(OverlapM3(CubeAt(0, 0, 0, 1), Cuboid{}), 0.0);
  EXPECT_NEAR(OverlapM3(CubeAt(0, 0, 0, 1), {{0, 0, 0}, {0.5, 0.0, 0.5}, 0.3}), 0.0, 1e-15);
}

TEST(OverlapM3, AgreesWithTheShareOfRandomPoints) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  constexpr int kPoints = 20000;
  for (int round = 0; round < 100; ++round) {
    const Cuboid a = RandomCuboid(&random);
    const Cuboid b = RandomCuboid(&random);
    int shared = 0;
    for (int i = 0; i < kPoints; ++i) {
      if (Contains(b, PointIn(a, {unit(random), unit(random), unit(random)}))) ++shared;
    }
    const double overlap_m3 = OverlapM3(a, b);
    // The sampled share of 20000 points has an error of at most 0.018 at five standard deviations.
    ASSERT_NEAR(overlap_m3, a.volume_m3() * shared / kPoints, 0.018 * a.volume_m3());
    ASSERT_NEAR(overlap_m3, OverlapM3(b, a), 1e-12);
    ASSERT_TRUE(overlap_m3 < 1e-12 || DistanceBetween(a, b) < 1e-12) << "round " << round;
  }
}

TEST(FitCuboid, NoPointsAndOnePoint) {
  EXPECT_EQ(FitCuboid({}), Cuboid{});
  const std::vector<Eigen::Vector3d> one{{9000.1, -2.3, 0.7}};
  const Cuboid cuboid = FitCuboid(one);
  EXPECT_EQ(cuboid.center_world, one.front());
  EXPECT_EQ(cuboid.size_m, Eigen::Vector3d::Zero());
  EXPECT_EQ(cuboid.yaw_rad, 0.0);
}

// The heading search has a resolution of an eighth of a degree.
constexpr double kHeadingErrorRad = 0.0022;

/// Returns the angle between two headings in radians, modulo pi: a box has no distinguished front.
double HeadingBetween(double a_rad, double b_rad) {
  return std::abs(std::remainder(a_rad - b_rad, kPi));
}

/// Returns random points of the box, and its corners.
std::vector<Eigen::Vector3d> PointsWithin(const Cuboid& cuboid, std::mt19937* random) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::vector<Eigen::Vector3d> points;
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) {
      for (const double z : {-1.0, 1.0}) points.push_back(PointIn(cuboid, {x, y, z}));
    }
  }
  for (int i = 0; i < 2000; ++i) {
    points.push_back(PointIn(cuboid, {unit(*random), unit(*random), unit(*random)}));
  }
  return points;
}

TEST(FitCuboid, RecoversTheBoxThatPointsWereDrawnFrom) {
  std::mt19937 random(3);
  for (const double yaw_rad : {-1.5, -0.7, 0.0, 0.3, 1.2, kPi / 2}) {
    const Cuboid box{{4000.0, -7000.0, 1.0}, {2.0, 0.5, 3.0}, yaw_rad};
    const Cuboid fit = FitCuboid(PointsWithin(box, &random));
    EXPECT_LT(HeadingBetween(fit.yaw_rad, yaw_rad), kHeadingErrorRad);
    EXPECT_LT((fit.center_world - box.center_world).norm(), 0.001);
    EXPECT_LT((fit.size_m - box.size_m).norm(), 0.006);
  }
}

/// Returns points on two adjacent upright sides, as a robot observes them at a corner, with
/// Gaussian noise of 4 mm.
std::vector<Eigen::Vector3d> PointsOfTwoSides(const Cuboid& cuboid, std::mt19937* random) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::normal_distribution<double> noise(0.0, 0.004);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 1500; ++i) {
    const double along = unit(*random);
    const bool is_on_long_side = i % 3 != 0;
    const Eigen::Vector3d place = is_on_long_side ? Eigen::Vector3d(along, -1.0, unit(*random))
                                                  : Eigen::Vector3d(1.0, along, unit(*random));
    const Eigen::Vector3d error(noise(*random), noise(*random), noise(*random));
    points.emplace_back(PointIn(cuboid, place) + error);
  }
  return points;
}

TEST(FitCuboid, TwoSidesThatMeetTellTheHeadingOfTheBox) {
  std::mt19937 random(5);
  for (const double yaw_rad : {-1.3, -0.8, -0.2, 0.0, 0.5, 1.1}) {
    const Cuboid box{{1.0, 2.0, 0.5}, {1.2, 0.8, 1.0}, yaw_rad};
    const Cuboid fit = FitCuboid(PointsOfTwoSides(box, &random));
    // The major axis of these points is more than 20 degrees from the heading of the box.
    EXPECT_LT(HeadingBetween(fit.yaw_rad, yaw_rad), 0.01) << yaw_rad;
    EXPECT_LT((fit.center_world - box.center_world).norm(), 0.02);
    EXPECT_LT((fit.size_m - box.size_m).norm(), 0.05);
  }
}

TEST(FitCuboid, XFollowsTheLongerSide) {
  std::mt19937 random(6);
  for (int degrees = -90; degrees < 90; degrees += 6) {
    const Cuboid box{{0.0, 0.0, 0.0}, {1.0, 0.6, 0.5}, degrees * kPi / 180.0};
    const Cuboid fit = FitCuboid(PointsOfTwoSides(box, &random));
    EXPECT_GT(fit.size_m.x(), fit.size_m.y());
    EXPECT_GT(fit.yaw_rad, -kPi / 2);
    EXPECT_LE(fit.yaw_rad, kPi / 2);
    EXPECT_LT(HeadingBetween(fit.yaw_rad, box.yaw_rad), 0.01) << degrees;
  }
}

TEST(FitCuboid, YawOfALineLiesInTheRightHalf) {
  for (int degrees = -360; degrees <= 360; degrees += 15) {
    const double yaw_rad = degrees * kPi / 180.0;
    const Eigen::Vector3d direction(std::cos(yaw_rad), std::sin(yaw_rad), 0.1);
    const std::vector<Eigen::Vector3d> points{-direction, Eigen::Vector3d::Zero(), direction};
    const Cuboid cuboid = FitCuboid(points);
    EXPECT_GT(cuboid.yaw_rad, -kPi / 2);
    EXPECT_LE(cuboid.yaw_rad, kPi / 2);
    EXPECT_LT(HeadingBetween(cuboid.yaw_rad, yaw_rad), kHeadingErrorRad) << degrees;
    EXPECT_NEAR(cuboid.size_m.x(), 2.0, 1e-4);
    EXPECT_NEAR(cuboid.size_m.y(), 0.0, 2.0 * kHeadingErrorRad);
    EXPECT_NEAR(cuboid.size_m.z(), 0.2, 1e-12);
  }
}

TEST(FitCuboid, PointsWithoutAHeadingAreStillEnclosed) {
  const std::vector<Eigen::Vector3d> square{{1, 1, 0}, {-1, 1, 0}, {-1, -1, 1}, {1, -1, 1}};
  const Cuboid cuboid = FitCuboid(square);
  EXPECT_TRUE(std::isfinite(cuboid.yaw_rad));
  EXPECT_EQ(cuboid, FitCuboid(square));
  for (const Eigen::Vector3d& point : square) EXPECT_NEAR(DistanceTo(cuboid, point), 0.0, 1e-12);
}

TEST(FitCuboid, GivenHeadingEnclosesTightly) {
  std::mt19937 random(4);
  std::normal_distribution<double> place(0.0, 1.0);
  std::vector<Eigen::Vector3d> points;
  points.reserve(100);
  for (int i = 0; i < 100; ++i) points.emplace_back(place(random), place(random), place(random));
  for (const double yaw_rad : {-3.0, -0.4, 0.0, 0.8, 2.5}) {
    const Cuboid cuboid = FitCuboid(points, yaw_rad);
    EXPECT_EQ(cuboid.yaw_rad, yaw_rad);
    Eigen::Vector3d highest = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& point : points) {
      EXPECT_NEAR(DistanceTo(cuboid, point), 0.0, 1e-12);
      const Eigen::Vector3d local = cuboid.T_world_cuboid().inverse() * point;
      highest = highest.cwiseMax(local.cwiseAbs());
    }
    EXPECT_TRUE((2.0 * highest).isApprox(cuboid.size_m, 1e-12));
  }
}

/// Returns points on a grid of 5 cm, `nx` x `ny` x `nz` of them from the origin on.
std::vector<Eigen::Vector3d> GridPoints(int nx, int ny, int nz) {
  std::vector<Eigen::Vector3d> points;
  for (int x = 0; x < nx; ++x) {
    for (int y = 0; y < ny; ++y) {
      for (int z = 0; z < nz; ++z) points.emplace_back(0.05 * x, 0.05 * y, 0.05 * z);
    }
  }
  return points;
}

TEST(FitCuboid, MayLeaveOutAFewPointsBeyondASide) {
  std::vector<Eigen::Vector3d> points = GridPoints(9, 7, 5);
  const Cuboid clean = FitCuboid(points, 0.0);
  for (int y = 0; y < 7; ++y) points.emplace_back(0.45, 0.05 * y, 0.0);
  const Cuboid enclosing = FitCuboid(points, 0.0);
  EXPECT_NEAR(enclosing.size_m.x(), clean.size_m.x() + 0.05, 1e-12);
  const Cuboid fit = FitCuboid(points, 0.0, {.max_share = 0.1, .max_m = 0.06});
  EXPECT_TRUE(fit.size_m.isApprox(clean.size_m, 1e-12));
  EXPECT_TRUE(fit.center_world.isApprox(clean.center_world, 1e-12));
  // More than the share is part of the object.
  const Cuboid whole = FitCuboid(points, 0.0, {.max_share = 0.05, .max_m = 0.06});
  EXPECT_TRUE(whole.size_m.isApprox(enclosing.size_m, 1e-12));
}

// A box of which the back was not seen, with floor in front of its sides.
TEST(FitCuboid, PointsBeyondTheSidesDoNotTurnTheHeading) {
  std::vector<Eigen::Vector3d> points;
  for (int z = 0; z < 7; ++z) {
    for (int y = 0; y <= 10; ++y) {
      points.emplace_back(0.0, 0.05 * y, 0.1 * z);
      points.emplace_back(0.7, 0.05 * y, 0.1 * z);
    }
    for (int x = 1; x < 14; ++x) points.emplace_back(0.05 * x, 0.0, 0.1 * z);
  }
  for (const double y : {0.45, 0.5}) points.emplace_back(-0.1, y, 0.0);
  for (const double x : {0.6, 0.65}) points.emplace_back(x, -0.1, 0.0);
  points.emplace_back(0.8, 0.0, 0.0);
  EXPECT_GT(std::abs(FitCuboid(points).yaw_rad), 5.0 / 180.0 * M_PI);
  const Cuboid fit = FitCuboid(points, {.max_share = 0.04, .max_m = 0.1});
  EXPECT_NEAR(fit.yaw_rad, 0.0, 1.0 / 180.0 * M_PI);
  EXPECT_NEAR(fit.size_m.x(), 0.7, 0.02);
  EXPECT_NEAR(fit.size_m.y(), 0.5, 0.02);
}

std::size_t CountWithin(const std::vector<double>& along_m, double low_m, double high_m) {
  return static_cast<std::size_t>(std::count_if(along_m.begin(), along_m.end(), [&](double at_m) {
    return at_m >= low_m && at_m <= high_m;
  }));
}

/// Returns the side at the high end of positions, metres: without outer layers of few points, the
/// lowest one that leaves out a share of the points just inside it.
double HighSideOf(std::vector<double> along_m, const CuboidMargin& margin) {
  const auto is_few = [&](std::size_t count, std::size_t others) {
    return static_cast<double>(count) <= margin.max_share * static_cast<double>(others);
  };
  std::sort(along_m.begin(), along_m.end());
  while (true) {
    const double layer_m = along_m.back() - margin.max_m;
    std::vector<double> rest_m = along_m;
    std::erase_if(rest_m, [&](double at_m) { return at_m >= layer_m; });
    if (rest_m.empty()) break;
    const std::size_t next = CountWithin(rest_m, rest_m.back() - margin.max_m, rest_m.back());
    if (!is_few(along_m.size() - rest_m.size(), next)) break;
    along_m = rest_m;
  }
  const double farthest_m = along_m.back();
  for (const double candidate_m : along_m) {
    if (candidate_m < farthest_m - margin.max_m) continue;
    const std::size_t inside = CountWithin(along_m, candidate_m - margin.max_m, candidate_m);
    const std::size_t all = CountWithin(along_m, candidate_m, farthest_m);
    const std::size_t here = CountWithin(along_m, candidate_m, candidate_m);
    if (is_few(all - here, inside)) return candidate_m;
  }
  return farthest_m;
}

TEST(FitCuboid, ASideLeavesOutAShareOfThePointsJustInsideIt) {
  constexpr CuboidMargin kMargin = {.max_share = 0.1, .max_m = 0.1};
  std::mt19937 random(1);
  std::normal_distribution<double> place(0.0, 0.2);
  for (const std::size_t count : {5U, 100U, 590U, 620U, 2000U}) {
    std::vector<Eigen::Vector3d> points;
    std::vector<double> x;
    std::vector<double> minus_x;
    std::vector<double> z;
    for (std::size_t i = 0; i < count; ++i) {
      points.emplace_back(place(random), place(random), place(random));
      x.push_back(points.back().x());
      minus_x.push_back(-points.back().x());
      z.push_back(points.back().z());
    }
    const Cuboid fit = FitCuboid(points, 0.0, kMargin);
    const double high_x_m = fit.center_world.x() + 0.5 * fit.size_m.x();
    const double low_x_m = fit.center_world.x() - 0.5 * fit.size_m.x();
    EXPECT_NEAR(high_x_m, HighSideOf(x, kMargin), 1e-12) << count;
    EXPECT_NEAR(low_x_m, -HighSideOf(minus_x, kMargin), 1e-12) << count;
    EXPECT_NEAR(fit.highest_m(), HighSideOf(z, kMargin), 1e-12) << count;
    EXPECT_NEAR(fit.lowest_m(), *std::min_element(z.begin(), z.end()), 1e-12) << count;
  }
}

TEST(FitCuboid, LeavesOutAStrayPointFarFromTheSide) {
  std::vector<Eigen::Vector3d> points = GridPoints(9, 7, 5);
  points.emplace_back(1.0, 0.0, 0.0);
  const Cuboid fit = FitCuboid(points, 0.0, {.max_share = 0.1, .max_m = 0.1});
  EXPECT_NEAR(fit.center_world.x() + 0.5 * fit.size_m.x(), 0.4, 1e-12);
}

TEST(FitCuboid, KeepsAPoleThatIsLongerThanTheMargin) {
  std::vector<Eigen::Vector3d> points = GridPoints(9, 7, 5);
  for (int i = 1; i <= 8; ++i) points.emplace_back(0.2, 0.15, 0.2 + 0.05 * i);
  const Cuboid fit = FitCuboid(points, 0.0, {.max_share = 0.1, .max_m = 0.1});
  EXPECT_NEAR(fit.highest_m(), 0.6, 1e-12);
}

// The ends of a board are few of its points, and as many as anywhere along it.
TEST(FitCuboid, WithAMarginALongBoardKeepsItsEnds) {
  const Cuboid fit = FitCuboid(GridPoints(61, 7, 1), {.max_share = 0.1, .max_m = 0.1});
  EXPECT_NEAR(fit.size_m.x(), 3.0, 1e-6);
  EXPECT_NEAR(fit.size_m.y(), 0.3, 1e-6);
}

TEST(FitCuboid, WithAMarginATableReachesTheFloor) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i <= 20; ++i) {
    for (int k = 0; k <= 12; ++k) points.emplace_back(0.05 * i, 0.05 * k, 0.7);
  }
  for (int level = 0; level < 14; ++level) {
    for (const double x : {0.0, 1.0}) points.emplace_back(x, 0.0, 0.05 * level);
  }
  const Cuboid fit = FitCuboid(points, {.max_share = 0.04, .max_m = 0.1});
  EXPECT_NEAR(fit.lowest_m(), 0.0, 1e-12);
  EXPECT_NEAR(fit.highest_m(), 0.7, 1e-12);
}

TEST(FitCuboid, WithAMarginFewPointsHaveNoNegativeSize) {
  for (int count = 1; count <= 4; ++count) {
    const std::vector<Eigen::Vector3d> points = GridPoints(count, 1, 1);
    const Cuboid fit = FitCuboid(points, 0.3, {.max_share = 1.0, .max_m = 10.0});
    EXPECT_GE(fit.size_m.minCoeff(), 0.0) << count;
  }
}

TEST(MajorAxisCuboid, HasTheHeadingOfTheLongestSpread) {
  const Eigen::Rotation2Dd turn(0.4);
  std::vector<Eigen::Vector3d> points;
  for (int i = -20; i <= 20; ++i) {
    for (int k = -5; k <= 5; ++k) {
      const Eigen::Vector2d plan = turn * Eigen::Vector2d(0.05 * i, 0.05 * k);
      points.emplace_back(3.0 + plan.x(), -1.0 + plan.y(), 0.1 * (i % 3));
    }
  }
  const Cuboid cuboid = MajorAxisCuboid(points);
  EXPECT_NEAR(std::remainder(cuboid.yaw_rad - 0.4, std::numbers::pi), 0.0, 1e-9);
  EXPECT_NEAR(cuboid.size_m.x(), 2.0, 1e-9);
  EXPECT_NEAR(cuboid.size_m.y(), 0.5, 1e-9);
  EXPECT_NEAR(cuboid.size_m.z(), 0.4, 1e-9);
  EXPECT_TRUE(cuboid.center_world.isApprox(Eigen::Vector3d(3.0, -1.0, 0.0), 1e-9));
  EXPECT_EQ(MajorAxisCuboid({}), Cuboid());
}

}  // namespace
}  // namespace steadymap
