#include "core/objects/shape_match.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/analytic_solid.h"
#include "tests/support/default_scale.h"
#include "tests/support/object_edits.h"

namespace steadymap {
namespace {

using ::steadymap::testing::kScale;
using ::steadymap::testing::StoreVolume;

constexpr double kFreeCellM = 0.1;

/// Returns the match of two shapes with nothing known of the space around them.
ShapeMatch Match(const TrackedObject& before, const TrackedObject& after) {
  const FreeSpace unknown(kFreeCellM);
  return MatchShapes(
      before, after, FreeSpaceSince(unknown, Timestamp()), SurfaceMatchParameters(), kScale);
}

/// Returns a box that stands at `position_world`, turned by `yaw_rad`, seen from all sides.
TrackedObject StandingBox(std::uint64_t id,
                          const Eigen::Vector3d& size_m,
                          const Eigen::Vector3d& position_world,
                          double yaw_rad) {
  TrackedObject object(ObjectId(id), position_world, kScale);
  const Eigen::Vector3d half(0.5 * size_m.x(), 0.5 * size_m.y(), 0.0);
  const Box body(-half, half + Eigen::Vector3d(0.0, 0.0, size_m.z()));
  const Eigen::Vector3d reach = Eigen::Vector3d::Constant(kScale.truncation_m);
  StoreVolume(
      testing::MakeVolume(
          [&](const Eigen::Vector3d& point) { return testing::DistanceFrom({body}, point); },
          Box(body.min() - reach, body.max() + reach),
          kScale,
          [](const Eigen::Vector3d&) { return true; }),
      &object);
  testing::StateOf(&object).T_world_object.yaw_rad = yaw_rad;
  return object;
}

// The edges of small boxes are most of their surface at voxels of 5 cm.
TEST(MatchShapes, ASmallBoxAgreesWithItselfAtAnyYaw) {
  const Eigen::Vector3d size_m(0.4, 0.3, 0.3);
  const TrackedObject before = StandingBox(1, size_m, {0.0, 0.0, 0.0}, 0.0);
  for (const double yaw_rad : {0.0, 0.3, 0.8, 1.6}) {
    const TrackedObject after = StandingBox(2, size_m, {1.013, 0.52, 0.027}, yaw_rad);
    const ShapeMatch match = Match(before, after);
    EXPECT_GT(match.close_share(), 0.9) << yaw_rad;
  }
}

TEST(MatchShapes, TellsABoxFromOneThatIsLargerByTenCentimetres) {
  const TrackedObject small = StandingBox(1, {0.4, 0.3, 0.3}, {0.0, 0.0, 0.0}, 0.0);
  const TrackedObject large = StandingBox(2, {0.5, 0.32, 0.45}, {0.0, 1.0, 0.0}, 0.0);
  const TrackedObject after = StandingBox(3, {0.4, 0.3, 0.3}, {1.0, 0.5, 0.0}, 0.4);
  EXPECT_GT(Match(small, after).close_share(), Match(large, after).close_share() + 0.2);
}

// With its top at that of a low box, a high one would be 40 cm in the floor.
TEST(MatchShapes, ThingsOfWhichTheBottomIsKnownStandAtOneHeight) {
  const TrackedObject high = StandingBox(1, {0.4, 0.3, 0.8}, {0.0, 0.0, 0.0}, 0.0);
  const TrackedObject low = StandingBox(2, {0.4, 0.3, 0.4}, {1.0, 0.5, 0.0}, 0.0);
  const FreeSpace unknown(kFreeCellM);
  const FreeSpaceSince free_space(unknown, Timestamp());
  const SurfaceMatchParameters parameters;
  const auto height_of = [](const ShapeMatch& match) {
    return std::abs(match.T_world_object.translation().z());
  };
  EXPECT_GT(height_of(MatchShapes(high, low, free_space, parameters, kScale)), 0.3);
  EXPECT_LT(height_of(MatchShapes(high, low, free_space, parameters, kScale, 0.1)), 0.1);
}

TEST(MatchShapes, PlacesNoSurfaceInFreeSpace) {
  const TrackedObject high = StandingBox(1, {0.4, 0.3, 1.2}, {0.0, 0.0, 0.0}, 0.0);
  const TrackedObject low = StandingBox(2, {0.4, 0.3, 0.4}, {1.0, 0.5, 0.0}, 0.0);
  const double close_share = Match(high, low).close_share();
  EXPECT_GT(close_share, 0.7) << "what is above and below the low box is not known";
  FreeSpace around(kFreeCellM);
  std::vector<LeafOrigin> changed;
  for (int x = 0; x <= 12; ++x) {
    for (int y = 0; y <= 12; ++y) {
      const Eigen::Vector3d column(0.45 + kFreeCellM * x, kFreeCellM * y - 0.05, 0.65);
      around.MarkRay(column, {column.x(), column.y(), 1.65}, RayTime(), &changed);
      around.MarkRay(
          {column.x(), column.y(), -1.05}, {column.x(), column.y(), -0.25}, RayTime(), &changed);
    }
  }
  const ShapeMatch match =
      MatchShapes(high, low, FreeSpaceSince(around, Timestamp()), SurfaceMatchParameters(), kScale);
  EXPECT_LT(match.close_share(), close_share - 0.15);
  // What was seen free before the low box came tells nothing.
  const FreeSpaceSince later(around, Timestamp::FromSeconds(1.0));
  EXPECT_EQ(MatchShapes(high, low, later, SurfaceMatchParameters(), kScale).close_share(),
            close_share);
}

}  // namespace
}  // namespace steadymap
