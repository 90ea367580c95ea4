#include "core/objects/opposite_parts.h"

#include <vector>

#include <gtest/gtest.h>

namespace steadymap {
namespace {

constexpr double kSpacingM = 0.05;

/// Sets of points on upright squares of 0.4 m.
class Sides {
 public:
  /// Adds a square at `x_m`, the least y of which is `y_m`, that faces along x by `normal_x`.
  void Add(double x_m, double y_m, double normal_x) {
    std::vector<std::size_t>& part = parts_.emplace_back();
    for (int column = 0; column < 8; ++column) {
      for (int row = 0; row < 8; ++row) {
        part.push_back(points_.size());
        points_.push_back({{x_m, y_m + kSpacingM * column, kSpacingM * row}, {normal_x, 0.0, 0.0}});
      }
    }
  }

  /// Adds the same as points of no set.
  void AddStructure(double x_m, double y_m, double normal_x) {
    Add(x_m, y_m, normal_x);
    parts_.pop_back();
  }

  std::vector<std::size_t> Opposite() const {
    return FindOppositeParts(points_, parts_, kSpacingM, OppositeSideParameters());
  }

 private:
  std::vector<OrientedPoint> points_;
  std::vector<std::vector<std::size_t>> parts_;
};

TEST(FindOppositeParts, FrontAndBackOfABoxAreOpposite) {
  Sides sides;
  sides.Add(0.0, 0.0, -1.0);
  sides.Add(0.35, 0.0, 1.0);
  EXPECT_EQ(sides.Opposite(), (std::vector<std::size_t>{1, 0}));
}

TEST(FindOppositeParts, FacingSidesOfTwoBoxesAreNot) {
  Sides sides;
  sides.Add(0.0, 0.0, 1.0);
  sides.Add(0.35, 0.0, -1.0);
  EXPECT_EQ(sides.Opposite(), (std::vector<std::size_t>{0, 1}));
}

TEST(FindOppositeParts, ASurfaceBetweenHidesTheOppositeOne) {
  Sides sides;
  sides.Add(0.0, 0.0, -1.0);
  sides.Add(0.7, 0.0, 1.0);
  sides.AddStructure(0.35, 0.0, -1.0);
  EXPECT_EQ(sides.Opposite().front(), 0U);
}

TEST(FindOppositeParts, FewOppositePointsAreNoSolid) {
  Sides sides;
  sides.Add(0.0, 0.0, -1.0);
  sides.Add(0.35, 0.3, 1.0);
  EXPECT_EQ(sides.Opposite(), (std::vector<std::size_t>{0, 1}));
}

TEST(FindOppositeParts, ThingsAreNotThickerThanTheLimit) {
  Sides sides;
  sides.Add(0.0, 0.0, -1.0);
  sides.Add(OppositeSideParameters().max_thickness_m + 0.2, 0.0, 1.0);
  EXPECT_EQ(sides.Opposite(), (std::vector<std::size_t>{0, 1}));
}

}  // namespace
}  // namespace steadymap
