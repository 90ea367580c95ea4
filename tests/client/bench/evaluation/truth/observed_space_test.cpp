#include "client/bench/evaluation/truth/observed_space.h"

#include <limits>

#include <gtest/gtest.h>

namespace steadymap {
namespace {

// Returns a view from the origin along world x with the constant depth `depth_m`.
DepthView ViewAlongX(float depth_m) {
  DepthView view;
  view.camera = {64, 48, 60.0, 60.0, 31.5, 23.5};
  view.depth_m = Image<float>(64, 48, depth_m);
  view.T_world_camera.linear().col(0) = -Eigen::Vector3d::UnitY();
  view.T_world_camera.linear().col(1) = -Eigen::Vector3d::UnitZ();
  view.T_world_camera.linear().col(2) = Eigen::Vector3d::UnitX();
  return view;
}

TEST(ObservedSpace, ReachesToTheSurfaceAndNotBehind) {
  ObservedSpace space(0.2, 3.0);
  space.AddView(ViewAlongX(1.6F));
  EXPECT_TRUE(space.IsObserved({0, 0, 0}));
  EXPECT_TRUE(space.IsObserved({4, 0, 0}));
  EXPECT_TRUE(space.IsObserved({8, 0, 0}));
  EXPECT_FALSE(space.IsObserved({9, 0, 0}));
  EXPECT_FALSE(space.IsObserved({-1, 0, 0}));
  EXPECT_FALSE(space.IsObserved({1, 4, 0})) << "outside the picture";
}

TEST(ObservedSpace, HasNoHolesWithinTheView) {
  ObservedSpace space(0.2, 3.0);
  space.AddView(ViewAlongX(2.0F));
  // The view extends sideways to half the depth and upwards to 0.4 of it.
  for (int x = 3; x <= 9; ++x) {
    for (int y = -x / 2 + 1; y <= x / 2 - 1; ++y) {
      for (int z = -x / 3 + 1; z <= x / 3 - 1; ++z) {
        EXPECT_TRUE(space.IsObserved({x, y, z})) << x << ' ' << y << ' ' << z;
      }
    }
  }
}

TEST(ObservedSpace, EndsAtTheMaximumDepth) {
  for (const float depth_m : {5.0F, std::numeric_limits<float>::infinity()}) {
    ObservedSpace space(0.2, 3.0);
    space.AddView(ViewAlongX(depth_m));
    EXPECT_TRUE(space.IsObserved({15, 0, 0}));
    EXPECT_FALSE(space.IsObserved({16, 0, 0}));
  }
}

TEST(ObservedSpace, UnknownDepthTellsNothing) {
  ObservedSpace space(0.2, 3.0);
  space.AddView(ViewAlongX(0.0F));
  EXPECT_EQ(space.observed_count(), 0U);
}

TEST(ObservedSpace, VisitsWhatIsObservedOnce) {
  ObservedSpace space(0.1, 3.0);
  space.AddView(ViewAlongX(1.0F));
  std::size_t count = 0;
  space.ForEach([&](const VoxelIndex& voxel) {
    EXPECT_TRUE(space.IsObserved(voxel));
    ++count;
  });
  EXPECT_EQ(count, space.observed_count());
  EXPECT_GT(count, 300U);
}

TEST(ViewOf, TurnsUnitsIntoMetresAndNoReturnIntoZero) {
  Frame frame;
  frame.depth.units = Image<std::uint16_t>(3, 1);
  frame.depth.metres_per_unit = 0.002;
  frame.depth.units.At(0, 0) = 1500;
  frame.depth.units.At(1, 0) = kNoDepth;
  frame.depth.units.At(2, 0) = kInvalidDepth;
  const DepthView view = ViewOf(frame);
  EXPECT_FLOAT_EQ(view.depth_m.At(0, 0), 3.0F);
  EXPECT_EQ(view.depth_m.At(1, 0), 0.0F);
  EXPECT_EQ(view.depth_m.At(2, 0), 0.0F);
}

}  // namespace
}  // namespace steadymap
