// Small scenes with known ground truth, processed by POCD as published, including its failures.

#include "core/policy/paper_mapper.h"

#include <string>

#include <gtest/gtest.h>

#include "tests/core/policy/map_story.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Body;
using ::steadymap::testing::ConfigOf;
using ::steadymap::testing::CountSurfaceIn;
using ::steadymap::testing::FarWall;
using ::steadymap::testing::Goods;
using ::steadymap::testing::kGoodsClass;
using ::steadymap::testing::kWallClass;
using ::steadymap::testing::MapStory;
using ::steadymap::testing::SceneBody;

constexpr std::uint16_t kCartClass = 9;

MapStory PaperStory() { return MapStory(ConfigOf(UpdatePolicy::kPocdPaper)); }

TEST(PaperMapper, BelievesANewObjectAtOnce) {
  MapStory story = PaperStory();
  story.Look({FarWall(), Goods(0.0)}, 1);
  EXPECT_EQ(story.EventsOf(EventType::kCreated, kGoodsClass).size(), 1U);
  ASSERT_EQ(story.Present(kGoodsClass).size(), 1U);
  EXPECT_NEAR(story.Present(kGoodsClass)[0]->belief.stationarity(), 0.67, 1e-9);
}

TEST(PaperMapper, GrowsSureOfABoxThatStays) {
  MapStory story = PaperStory();
  story.Look({FarWall(), Goods(0.0)}, 20);
  ASSERT_FALSE(story.Present(kGoodsClass).empty());
  const MapObject& box = *story.Present(kGoodsClass).front();
  EXPECT_GT(box.supporting_frames, 10U);
  EXPECT_GT(box.belief.stationarity(), 0.8);
  EXPECT_GT(box.belief.alpha + box.belief.beta, 12.0) << "nothing caps what a belief gathers";
}

TEST(PaperMapper, RemovesABoxThatDisappeared) {
  MapStory story = PaperStory();
  story.Look({FarWall(), Goods(0.0)}, 20);
  story.Look({FarWall()}, 30);
  EXPECT_FALSE(story.EventsOf(EventType::kRemoved, kGoodsClass, Revision(20)).empty());
  EXPECT_TRUE(story.Present(kGoodsClass).empty());
}

// A failure of visibility by frustum, which visibility by depth avoids.
TEST(PaperMapper, DoubtsABoxThatIsOnlyHidden) {
  MapStory story = PaperStory();
  story.Look({FarWall(), Goods(0.0)}, 20);
  ASSERT_FALSE(story.Present(kGoodsClass).empty());
  const double before = story.Present(kGoodsClass).front()->belief.stationarity();
  story.Look({FarWall(), Goods(0.0), Body(kCartClass, {0.8, -0.8, -0.7}, {1.0, 0.8, 0.7})}, 3);
  for (const auto& box : story.Present(kGoodsClass)) {
    EXPECT_LT(box->belief.stationarity(), before);
  }
}

/// Returns the number of goods and carts created after 4 frames of a box and one of `next`.
std::size_t CountCreated(const SceneBody& next, const std::string& parameter, double value) {
  MapConfig config = ConfigOf(UpdatePolicy::kPocdPaper);
  if (!parameter.empty()) config.parameters[parameter] = value;
  MapStory story(config);
  story.Look({FarWall(), Goods(0.0)}, 4);
  story.Look({FarWall(), next}, 1);
  return story.EventsOf(EventType::kCreated, kGoodsClass).size() +
         story.EventsOf(EventType::kCreated, kCartClass).size();
}

TEST(PaperMapper, MatchesOnlyWithinItsGates) {
  const SceneBody nearer = Goods(0.0, 1.5);
  EXPECT_EQ(CountCreated(nearer, "", 0.0), 1U) << "matched";
  EXPECT_EQ(CountCreated(nearer, "association_distance_m", 0.05), 2U);
  EXPECT_EQ(CountCreated(nearer, "cost_cutoff", 0.05), 2U);
  EXPECT_EQ(CountCreated(nearer, "position_weight", 100.0), 2U) << "dearer than the cutoff";
  EXPECT_GT(CountCreated(nearer, "icp_outlier_distance_m", 0.001), 2U) << "all are outliers";
  EXPECT_EQ(CountCreated(nearer, "icp_pair_distance_m", 0.01), 2U) << "no pairs";

  SceneBody cart = Goods(0.0);
  cart.label = kCartClass;
  EXPECT_EQ(CountCreated(cart, "", 0.0), 2U) << "another class";
  EXPECT_EQ(CountCreated(cart, "class_weight", 0.0), 1U);
}

// A change of more than tau / 2 discards the observation: it neither becomes an object nor surface.
TEST(PaperMapper, FusesNothingOfABoxThatChanged) {
  MapStory story = PaperStory();
  story.Look({FarWall(), Goods(0.0)}, 20);
  ASSERT_EQ(story.Present(kGoodsClass).size(), 1U);
  const ObjectId id = story.Present(kGoodsClass).front()->id;
  const std::size_t events = story.events().size();
  story.Look({FarWall(), Goods(0.0, 1.4)}, 2);
  ASSERT_EQ(story.Present(kGoodsClass).size(), 1U);
  const MapObject& box = *story.Present(kGoodsClass).front();
  EXPECT_EQ(box.id, id);
  EXPECT_EQ(story.events().size(), events);
  const Box new_front(Eigen::Vector3d(1.3, -0.2, -0.2), Eigen::Vector3d(1.5, 0.2, 0.2));
  EXPECT_EQ(CountSurfaceIn(story.map(), new_front), 0U);
  EXPECT_GT(box.belief.change_mean_m, 0.0) << "it came nearer";
}

TEST(PaperMapper, MeasuresANegativeChangeOfABoxThatMovedAway) {
  MapStory story = PaperStory();
  story.Look({FarWall(), Goods(0.0)}, 20);
  story.Look({FarWall(), Goods(0.0, 1.8)}, 2);
  ASSERT_EQ(story.Present(kGoodsClass).size(), 1U);
  EXPECT_LT(story.Present(kGoodsClass).front()->belief.change_mean_m, 0.0);
}

}  // namespace
}  // namespace steadymap
