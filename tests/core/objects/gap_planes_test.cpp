#include "core/objects/gap_planes.h"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace steadymap {
namespace {

constexpr double kVoxelM = 0.05;
constexpr double kGapHeightM = 0.4;

/// A gap of `width_m` through the origin, along the direction `yaw_rad` of the ground.
struct TrueGap {
  double yaw_rad = 0.0;
  double width_m = 0.05;

  Eigen::Vector2d along() const { return {std::cos(yaw_rad), std::sin(yaw_rad)}; }
};

/// Returns what a frame sees that looks through a gap at an angle to it: rays go on in the gap
/// until they hit one of its sides, at most 1 m.
std::vector<GapInView> SeenAt(const TrueGap& gap, double angle_rad) {
  std::vector<GapInView> gaps;
  const double way_m = std::min(1.0, gap.width_m / std::max(1e-3, std::abs(std::tan(angle_rad))));
  for (int row = 0; row < 20; ++row) {
    GapInView seen;
    seen.middle_world = {0.0, 0.0, row * 0.02};
    seen.view_world = Eigen::Rotation2Dd(gap.yaw_rad + angle_rad) * Eigen::Vector2d::UnitX();
    seen.width_m = gap.width_m;
    seen.max_angle_rad = gap.width_m / way_m;
    gaps.push_back(seen);
  }
  return gaps;
}

std::vector<GapPlane> PlanesOf(const std::vector<SeenGap>& seen) {
  return FindGapPlanes(GapPlaneParameters(), seen, kVoxelM);
}

TEST(FindGapPlanes, FramesFromRandomDirectionsTellThePlane) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  for (int trial = 0; trial < 50; ++trial) {
    const TrueGap gap{M_PI * number(random)};
    std::vector<SeenGap> seen;
    // One of them looks along the gap.
    AddGaps(SeenAt(gap, 0.03 * number(random)), kVoxelM, &seen);
    for (int i = 0; i < 8; ++i) {
      const bool from_behind = i % 2 == 1;
      AddGaps(SeenAt(gap, 0.7 * number(random) + (from_behind ? M_PI : 0.0)), kVoxelM, &seen);
    }
    const std::vector<GapPlane> planes = PlanesOf(seen);
    ASSERT_EQ(planes.size(), 1U);
    EXPECT_LT(std::abs(planes.front().normal_world.head<2>().dot(gap.along())), 0.08);
    EXPECT_EQ(planes.front().normal_world.z(), 0.0);
    EXPECT_NEAR(planes.front().width_m, gap.width_m, 1e-9);
    EXPECT_LT(planes.front().center_world.head<2>().norm(), 1e-9);
  }
}

TEST(FindGapPlanes, OneFrameMayBeWrong) {
  std::vector<SeenGap> seen;
  AddGaps(SeenAt({}, 0.0), kVoxelM, &seen);
  EXPECT_TRUE(PlanesOf(seen).empty());
  AddGaps(SeenAt({}, 0.0), kVoxelM, &seen);
  EXPECT_EQ(PlanesOf(seen).size(), 1U);
}

TEST(FindGapPlanes, ThreeThingsHaveTwoGaps) {
  std::vector<SeenGap> seen;
  for (int frame = 0; frame < 3; ++frame) {
    for (const double x_m : {0.0, 0.3}) {
      std::vector<GapInView> gaps = SeenAt({M_PI_2}, 0.0);
      for (GapInView& gap : gaps) gap.middle_world.x() += x_m;
      AddGaps(gaps, kVoxelM, &seen);
    }
  }
  EXPECT_EQ(PlanesOf(seen).size(), 2U);
}

TEST(MergeGaps, PlacesOfSeveralObjectsAddUpToTheSameAsThoseOfOne) {
  std::vector<SeenGap> all;
  std::vector<SeenGap> first;
  std::vector<SeenGap> second;
  for (const double angle_rad : {0.0, 0.1, -0.3}) {
    AddGaps(SeenAt({}, angle_rad), kVoxelM, &all);
    AddGaps(SeenAt({}, angle_rad), kVoxelM, angle_rad > 0.0 ? &second : &first);
  }
  MergeGaps(second, &first);
  ASSERT_EQ(first.size(), all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(first[i].cell, all[i].cell);
    EXPECT_EQ(first[i].frames, all[i].frames);
    EXPECT_NEAR(first[i].weight, all[i].weight, 1e-9);
    EXPECT_LT((first[i].middle_world - all[i].middle_world).norm(), 1e-12);
    EXPECT_LT((first[i].view_sum_world - all[i].view_sum_world).norm(), 1e-9);
  }
}

TEST(MergeGaps, KeepsALimitedNumber) {
  std::vector<SeenGap> added(1 << 16);
  for (std::size_t i = 0; i < added.size(); ++i) {
    added[i] = {.cell = {static_cast<std::int32_t>(i), 0, 0}, .frames = 1, .weight = 1.0};
  }
  std::vector<SeenGap> seen;
  MergeGaps(added, &seen);
  EXPECT_LT(seen.size(), added.size());
  // What is known goes on to be counted.
  const std::size_t count = seen.size();
  MergeGaps(added, &seen);
  EXPECT_EQ(seen.size(), count);
  EXPECT_EQ(seen.front().frames, 2U);
}

/// Two boxes with their fronts in the plane x = 0, on both sides of a gap along x.
class DividesTest : public ::testing::Test {
 protected:
  DividesTest() {
    std::vector<SeenGap> seen;
    for (int frame = 0; frame < 3; ++frame) AddGaps(SeenAt({}, 0.0), kVoxelM, &seen);
    gap_ = PlanesOf(seen).front();
  }

  /// Adds a rectangle of surface from a corner along two edges.
  void Add(const Eigen::Vector3d& corner, const Eigen::Vector3d& u_m, const Eigen::Vector3d& v_m) {
    const Eigen::Vector3d normal = u_m.cross(v_m).normalized();
    const int columns = static_cast<int>(u_m.norm() / kVoxelM);
    const int rows = static_cast<int>(v_m.norm() / kVoxelM);
    for (int i = 0; i <= columns; ++i) {
      for (int j = 0; j <= rows; ++j) {
        points_.push_back(
            {corner + kVoxelM * (i * u_m.normalized() + j * v_m.normalized()), normal});
      }
    }
  }

  void AddFront() {
    Add({0.0, -0.5, 0.0}, Eigen::Vector3d::UnitY(), kGapHeightM * Eigen::Vector3d::UnitZ());
  }

  bool Divide() const { return Divides(gap_, points_, kVoxelM); }

  GapPlane gap_;
  std::vector<OrientedPoint> points_;
};

TEST_F(DividesTest, SurfaceFusedAcrossAGapIsOfTwoThings) {
  AddFront();
  EXPECT_TRUE(Divide());
  EXPECT_TRUE(IsBeside(gap_, points_, kVoxelM));
}

TEST_F(DividesTest, ThingsConnectedBehindAGapAreOne) {
  AddFront();
  Add({0.0, -0.5, kGapHeightM}, 0.5 * Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY());
  EXPECT_FALSE(Divide());
}

TEST_F(DividesTest, AnOpeningFromAboveIsNoGap) {
  // A crate with walls of a voxel; frames look into it between opposite walls.
  std::vector<SeenGap> seen;
  for (int frame = 0; frame < 3; ++frame) {
    std::vector<GapInView> gaps;
    for (int i = 0; i < 25; ++i) {
      GapInView gap;
      gap.middle_world = {i * 0.02, 0.0, kGapHeightM};
      gap.width_m = 0.2;
      gap.max_angle_rad = 0.5;
      gaps.push_back(gap);
    }
    AddGaps(gaps, kVoxelM, &seen);
  }
  gap_ = PlanesOf(seen).front();
  const Eigen::Vector3d up = kGapHeightM * Eigen::Vector3d::UnitZ();
  Add({0.0, -0.1, 0.0}, 0.5 * Eigen::Vector3d::UnitX(), up);
  Add({0.0, 0.1, 0.0}, 0.5 * Eigen::Vector3d::UnitX(), up);
  EXPECT_FALSE(Divide());
}

TEST_F(DividesTest, TheSidesOfAGapDoNotConnectIt) {
  AddFront();
  Add({0.0, 0.04, 0.0}, 0.6 * Eigen::Vector3d::UnitX(), kGapHeightM * Eigen::Vector3d::UnitZ());
  EXPECT_TRUE(Divide());
}

TEST_F(DividesTest, SurfaceOnOneSideIsNotDivided) {
  Add({0.0, 0.05, 0.0}, Eigen::Vector3d::UnitY(), kGapHeightM * Eigen::Vector3d::UnitZ());
  EXPECT_FALSE(Divide());
  EXPECT_TRUE(IsBeside(gap_, points_, kVoxelM));
}

TEST_F(DividesTest, SurfaceFarFromAGapIsNotBesideIt) {
  Add({1.0, -0.5, 0.0}, Eigen::Vector3d::UnitY(), kGapHeightM * Eigen::Vector3d::UnitZ());
  EXPECT_FALSE(IsBeside(gap_, points_, kVoxelM));
  EXPECT_FALSE(Divide());
}

}  // namespace
}  // namespace steadymap
