#include "core/geometry/box_tree.h"

#include <algorithm>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace steadymap {
namespace {

Eigen::Vector3d RandomPoint(std::mt19937* random, double side_m) {
  std::uniform_real_distribution<double> coordinate(-side_m, side_m);
  return {coordinate(*random), coordinate(*random), coordinate(*random)};
}

std::vector<Box> RandomBoxes(std::size_t count, std::mt19937* random) {
  std::vector<Box> boxes;
  boxes.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d center = RandomPoint(random, 10.0);
    const Eigen::Vector3d half = RandomPoint(random, 1.5).cwiseAbs();
    boxes.emplace_back(center - half, center + half);
  }
  return boxes;
}

std::vector<std::size_t> At(const BoxTree& tree, const Eigen::Vector3d& point) {
  std::vector<std::size_t> found;
  tree.VisitAt(point, [&found](std::size_t box) { found.push_back(box); });
  std::sort(found.begin(), found.end());
  return found;
}

TEST(BoxTree, WithoutBoxesNothingIsFound) {
  const BoxTree tree({});
  EXPECT_TRUE(At(tree, Eigen::Vector3d::Zero()).empty());
  EXPECT_TRUE(tree.FindAlong(Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX(), 9.0).empty());
}

TEST(BoxTree, FindsTheBoxesThatHoldAPoint) {
  std::mt19937 random(1);
  for (const std::size_t count : {1U, 4U, 5U, 300U}) {
    const std::vector<Box> boxes = RandomBoxes(count, &random);
    const BoxTree tree(boxes);
    for (int i = 0; i < 1000; ++i) {
      const Eigen::Vector3d point = RandomPoint(&random, 11.0);
      std::vector<std::size_t> truth;
      for (std::size_t box = 0; box < count; ++box) {
        if (boxes[box].contains(point)) truth.push_back(box);
      }
      ASSERT_EQ(At(tree, point), truth);
    }
  }
}

/// Returns the boxes that a ray hits, found by sampling the ray. May miss a box that the ray only
/// grazes.
std::vector<std::size_t> StepAlong(const std::vector<Box>& boxes,
                                   const Eigen::Vector3d& origin,
                                   const Eigen::Vector3d& direction,
                                   double max_range_m) {
  constexpr double kStepM = 0.02;
  std::vector<std::size_t> met;
  for (std::size_t box = 0; box < boxes.size(); ++box) {
    bool is_met = false;
    for (int step = 0; step * kStepM < max_range_m && !is_met; ++step) {
      is_met = boxes[box].contains(Eigen::Vector3d(origin + step * kStepM * direction));
    }
    if (is_met) met.push_back(box);
  }
  return met;
}

TEST(BoxTree, FindsTheBoxesOnARaysWayNearestFirst) {
  std::mt19937 random(2);
  const std::vector<Box> boxes = RandomBoxes(200, &random);
  const BoxTree tree(boxes);
  std::size_t crossed = 0;
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d origin = RandomPoint(&random, 12.0);
    const Eigen::Vector3d direction = RandomPoint(&random, 1.0).normalized();
    const std::vector<BoxTree::Crossing> crossings = tree.FindAlong(origin, direction, 8.0);
    EXPECT_TRUE(std::is_sorted(crossings.begin(), crossings.end()));
    std::vector<bool> found(boxes.size());
    for (const BoxTree::Crossing& crossing : crossings) {
      found[crossing.box] = true;
      const Eigen::Vector3d entry = origin + crossing.entry_m * direction;
      EXPECT_NEAR(boxes[crossing.box].exteriorDistance(entry), 0.0, 1e-9);
      if (crossing.entry_m > 0.0) {
        EXPECT_FALSE(boxes[crossing.box].contains(
            Eigen::Vector3d(origin + (crossing.entry_m - 1e-6) * direction)));
      }
    }
    for (const std::size_t box : StepAlong(boxes, origin, direction, 8.0)) {
      ASSERT_TRUE(found[box]) << box;
    }
    crossed += crossings.size();
  }
  EXPECT_GT(crossed, 100U);
}

TEST(BoxTree, RaysAlongAnAxisAndInABordersPlaneAreFound) {
  const BoxTree tree({Box(Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(2, 1, 1))});
  const auto along_x = [&tree](double y, double max_range_m) {
    return tree.FindAlong({0.0, y, 0.5}, Eigen::Vector3d::UnitX(), max_range_m);
  };
  ASSERT_EQ(along_x(0.5, 9.0).size(), 1U);
  EXPECT_EQ(along_x(0.5, 9.0)[0].entry_m, 1.0);
  EXPECT_EQ(along_x(1.0, 9.0).size(), 1U);
  EXPECT_TRUE(along_x(1.01, 9.0).empty());
  EXPECT_TRUE(along_x(0.5, 0.99).empty());
  EXPECT_TRUE(tree.FindAlong({0.0, 0.5, 0.5}, -Eigen::Vector3d::UnitX(), 9.0).empty());
}

TEST(BoxTree, ManyBoxesInOnePlaceAreAllFound) {
  const BoxTree tree(std::vector<Box>(100, Box(Eigen::Vector3d::Zero(), Eigen::Vector3d::Ones())));
  EXPECT_EQ(At(tree, {0.5, 0.5, 0.5}).size(), 100U);
}

TEST(BoxTree, PointsThatAreNotFiniteLieNowhere) {
  const BoxTree tree({Box(Eigen::Vector3d::Zero(), Eigen::Vector3d::Ones())});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(At(tree, {nan, 0.5, 0.5}).empty());
  EXPECT_TRUE(At(tree, {0.5, 0.5, std::numeric_limits<double>::infinity()}).empty());
}

}  // namespace
}  // namespace steadymap
