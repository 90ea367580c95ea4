// Two objects with connected surfaces in a frame: the halves of a wall that fills the image.

#include "core/objects/object_merge.h"

#include <vector>

#include <gtest/gtest.h>

#include "core/types/map_config.h"
#include "tests/support/analytic_samples.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/analytic_solid.h"
#include "tests/support/object_edits.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Body;
using ::steadymap::testing::kGoodsClass;
using ::steadymap::testing::kWallClass;
using ::steadymap::testing::MakeVolume;
using ::steadymap::testing::SamplesOf;
using ::steadymap::testing::Solid;

class MergeConnectedTest : public ::testing::Test {
 protected:
  MergeConnectedTest() { map_.BeginFrame(Revision(1), Timestamp::FromSeconds(100.0)); }

  /// Adds half a wall, left (`y` > 0) or right of the image centre.
  TrackedObject* Put(bool is_left, ObjectStatus standing, double came_s = 99.0) {
    TrackedObject& half = map_.AddObject(Eigen::Vector3d::Zero());
    const double low_m = is_left ? 0.0 : -1.0;
    const Solid wall = {Box(Eigen::Vector3d(2.0, low_m, 0.0), Eigen::Vector3d(2.3, low_m + 1, 1))};
    ObjectEdit edit = map_.Edit(&half);
    testing::StoreVolume(MakeVolume(wall, map_.scale()), &edit);
    ObjectState& state = edit.state();
    state.class_id = ClassId(kWallClass);
    state.status = standing;
    state.in_place_since = Timestamp::FromSeconds(came_s);
    in_view_.push_back({&half, 0, 10, 0, 10});
    if (is_left) left_ = static_cast<std::uint32_t>(in_view_.size());
    return &half;
  }

  std::vector<ObjectEvent> Merge(const MergeParameters& parameters = {}) {
    const SampleGrid samples =
        SamplesOf({Body(kWallClass, {2.0, -4.0, -4.0}, {2.3, 4.0, 4.0})}, {});
    Association association;
    for (std::size_t index = 0; index < samples.size(); ++index) {
      const bool is_left = static_cast<int>(index) % samples.width() < samples.width() / 2;
      association.owner.push_back(is_left ? left_ : 3 - left_);
    }
    MergeConnected(samples, association, in_view_, parameters, &map_);
    map_.EndFrame();
    return map_.Commit().delta.events;
  }

  WorkingMap map_{MapConfig()};
  std::vector<ObjectInView> in_view_;
  std::uint32_t left_ = 0;  ///< Owner of the samples left of the image centre.
};

TEST_F(MergeConnectedTest, KeepsTheOlderOfTwoThatTheMapShows) {
  const ObjectId older = Put(true, ObjectStatus::kPresent)->id();
  const ObjectId newer = Put(false, ObjectStatus::kPresent)->id();
  const std::vector<ObjectEvent> events = Merge();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].type, EventType::kMerged);
  EXPECT_EQ(events[0].object, newer);
  EXPECT_EQ(events[0].related, older);
  ASSERT_EQ(map_.objects().size(), 1U);
  const TrackedObject& whole = map_.objects().begin()->second;
  EXPECT_EQ(whole.id(), older);
  EXPECT_NEAR(whole.cuboid().size_m.maxCoeff(), 2.0, 0.1);
}

// Otherwise an object already in the published map would be reported as new again.
TEST_F(MergeConnectedTest, KeepsTheOneThatTheMapShowsThoughItIsNewer) {
  Put(true, ObjectStatus::kTentative);
  const ObjectId shown = Put(false, ObjectStatus::kPresent)->id();
  EXPECT_TRUE(Merge().empty());
  ASSERT_EQ(map_.objects().size(), 1U);
  EXPECT_EQ(map_.objects().begin()->first, shown);
}

TEST_F(MergeConnectedTest, LeavesApartWhatCameOnDifferentVisits) {
  Put(true, ObjectStatus::kPresent, 10.0);
  Put(false, ObjectStatus::kPresent);
  EXPECT_TRUE(Merge().empty());
  EXPECT_EQ(map_.objects().size(), 2U);
}

TEST_F(MergeConnectedTest, LeavesApartWhatIsOfDifferentClasses) {
  {
    ObjectEdit edit = map_.Edit(Put(true, ObjectStatus::kPresent));
    edit.state().class_id = ClassId(kGoodsClass);
  }
  Put(false, ObjectStatus::kPresent);
  EXPECT_TRUE(Merge().empty());
}

TEST_F(MergeConnectedTest, LeavesAllApartIfItIsToldTo) {
  Put(true, ObjectStatus::kPresent);
  Put(false, ObjectStatus::kPresent);
  EXPECT_TRUE(Merge({.contacts = 0}).empty());
}

}  // namespace
}  // namespace steadymap
