#include "core/objects/place_matches.h"

#include <vector>

#include <gtest/gtest.h>

#include "tests/support/analytic_solid.h"
#include "tests/support/default_scale.h"
#include "tests/support/object_edits.h"

namespace steadymap {
namespace {

using ::steadymap::testing::kScale;
using ::steadymap::testing::StoreVolume;

/// Returns a post at `x_m` of which only one row of voxels is observed, on both sides of its face:
/// no eight of them are around one point.
TrackedObject PostAt(std::uint64_t id, double x_m) {
  TrackedObject object(ObjectId(id), {x_m, 0.0, 0.0}, kScale);
  const double row_m = 0.4 * kScale.voxel_size_m;
  const Box row(Eigen::Vector3d(-row_m, -row_m, -0.5),
                Eigen::Vector3d(kScale.voxel_size_m + row_m, row_m, 0.5));
  const auto distance_m = [](const Eigen::Vector3d& point) { return point.x(); };
  const auto is_observed = [&](const Eigen::Vector3d& point) { return row.contains(point); };
  StoreVolume(testing::MakeVolume(distance_m, row, kScale, is_observed), &object);
  return object;
}

/// Returns the matches of a post of the session at `seen_x_m` with a known one at the origin.
std::vector<PlaceMatch> MatchesAt(double seen_x_m) {
  TrackedObject known = PostAt(1, 0.0);
  TrackedObject seen = PostAt(2, seen_x_m);
  SessionObjects objects;
  objects.AddKnown(&known, Standing::kUnknown);
  objects.AddSeen(&seen, /*has_left=*/false);
  return FindPlaceMatches(SessionIdentityParameters(), kScale, &objects);
}

TEST(FindPlaceMatches, FindsWhatIsTooThinToRegister) {
  const std::vector<PlaceMatch> matches = MatchesAt(0.01);
  ASSERT_EQ(matches.size(), 1U);
  EXPECT_TRUE(matches.front().fits_at_rest);
  EXPECT_GT(matches.front().fit, 0.9);
}

TEST(FindPlaceMatches, AThinThingElsewhereIsNotInPlace) {
  EXPECT_TRUE(MatchesAt(2.0 * kScale.voxel_size_m).empty());
}

TEST(SessionObjects, ANewRegionHasThePoseErrorOfTheRest) {
  TrackedObject whole = PostAt(1, 0.0);
  TrackedObject region = PostAt(2, 1.0);
  SessionObjects objects;
  objects.AddSeen(&whole, /*has_left=*/false);
  objects.seen.front().pose_error_m = 0.05;
  objects.AddRegion(&region, objects.seen.front());
  EXPECT_TRUE(objects.seen.back().is_new_region);
  EXPECT_EQ(objects.seen.back().index, 1U);
  EXPECT_EQ(objects.seen.back().pose_error_m, 0.05);
}

}  // namespace
}  // namespace steadymap
