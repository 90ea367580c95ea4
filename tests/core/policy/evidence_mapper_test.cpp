// Visits to a scene of goods in front of a wall.

#include "core/policy/evidence_mapper.h"

#include <vector>

#include <gtest/gtest.h>

#include "tests/core/policy/map_story.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Body;
using ::steadymap::testing::ExpectSameMap;
using ::steadymap::testing::FarWall;
using ::steadymap::testing::Goods;
using ::steadymap::testing::kGoodsClass;
using ::steadymap::testing::MapStory;
using ::steadymap::testing::PocdConfig;

constexpr int kFrames = 10;

MapperOptions BySession() {
  MapperOptions options;
  options.decides_by_session = true;
  return options;
}

class EvidenceMapperTest : public ::testing::Test {
 protected:
  /// Looks at a scene for one session.
  void Visit(const testing::Scene& scene) {
    story_.Look(scene, kFrames, visit_++);
    story_.EndSession();
  }

  void VisitWithoutLabels(const testing::Scene& scene) {
    std::vector<Frame> frames =
        testing::LookAtScene(scene, visit_ * (kFrames + 1), kFrames, visit_);
    for (Frame& frame : frames) frame.labels = {};
    story_.Play(frames);
    story_.EndSession();
    ++visit_;
  }

  MapStory story_{PocdConfig(), BySession()};
  int visit_ = 0;
};

TEST_F(EvidenceMapperTest, AnObjectIsAnnouncedOnceAtTheEndOfItsSession) {
  story_.Look({FarWall(), Goods(0.0)}, kFrames);
  EXPECT_TRUE(story_.events().empty());
  story_.EndSession();
  EXPECT_EQ(story_.EventsOf(EventType::kCreated, kGoodsClass).size(), 1U);
  EXPECT_EQ(story_.Present(kGoodsClass).size(), 1U);
}

TEST_F(EvidenceMapperTest, AnotherVisitToAnUnchangedPlaceTellsNothing) {
  Visit({FarWall(), Goods(0.0)});
  const std::size_t told = story_.events().size();
  Visit({FarWall(), Goods(0.0)});
  EXPECT_EQ(story_.events().size(), told);
}

TEST_F(EvidenceMapperTest, WhatIsSeenThroughIsRemoved) {
  Visit({FarWall(), Goods(0.0)});
  Visit({FarWall()});
  EXPECT_EQ(story_.EventsOf(EventType::kRemoved, kGoodsClass).size(), 1U);
  EXPECT_TRUE(story_.Present(kGoodsClass).empty());
}

TEST_F(EvidenceMapperTest, AThingInAnotherPlaceHasMoved) {
  Visit({FarWall(), Goods(-0.4)});
  Visit({FarWall(), Goods(0.4)});
  EXPECT_EQ(story_.EventsOf(EventType::kMoved, kGoodsClass).size(), 1U);
  EXPECT_EQ(story_.Present(kGoodsClass).size(), 1U);
}

TEST_F(EvidenceMapperTest, NeighboursOfOneClassAreTwoAndOneMayLeave) {
  Visit({FarWall(), Goods(-0.35), Goods(0.35)});
  EXPECT_EQ(story_.EventsOf(EventType::kCreated, kGoodsClass).size(), 2U);
  Visit({FarWall(), Goods(-0.35)});
  EXPECT_EQ(story_.EventsOf(EventType::kRemoved, kGoodsClass).size(), 1U);
  EXPECT_EQ(story_.Present(kGoodsClass).size(), 1U);
}

TEST_F(EvidenceMapperTest, ASideAtAFlatAngleBelongsToItsThing) {
  Visit({FarWall(), Body(kGoodsClass, {1.2, 0.55, -0.3}, {2.2, 1.0, 0.3})});
  const auto things = story_.Present(kGoodsClass);
  ASSERT_EQ(things.size(), 1U);
  EXPECT_GT(things.front()->cuboid.size_m.x(), 0.8);
}

TEST_F(EvidenceMapperTest, FlatAnglesDoNotConnectNeighbours) {
  // In one line, so that the tops of both are one surface for a camera that looks along them.
  Visit({FarWall(),
         Body(kGoodsClass, {1.0, 0.1, -0.6}, {1.4, 0.6, -0.2}),
         Body(kGoodsClass, {1.5, 0.1, -0.6}, {1.9, 0.6, -0.2})});
  for (const auto& thing : story_.Present(kGoodsClass)) {
    EXPECT_LT(thing->cuboid.size_m.x(), 0.6);
  }
}

TEST_F(EvidenceMapperTest, WithoutLabelsAThingComesAndGoes) {
  VisitWithoutLabels({FarWall(), Goods(0.0)});
  ASSERT_EQ(story_.EventsOf(EventType::kCreated, kNoClass.value()).size(), 1U);
  EXPECT_EQ(story_.Present(kNoClass.value()).size(), 1U);
  VisitWithoutLabels({FarWall(), Goods(0.0)});
  EXPECT_EQ(story_.events().size(), 1U);
  VisitWithoutLabels({FarWall()});
  EXPECT_EQ(story_.EventsOf(EventType::kRemoved, kNoClass.value()).size(), 1U);
  EXPECT_TRUE(story_.Present(kNoClass.value()).empty());
}

TEST_F(EvidenceMapperTest, AFrameWithoutLabelsDoesNotDoubtALabelledThing) {
  Visit({FarWall(), Goods(0.0)});
  VisitWithoutLabels({FarWall(), Goods(0.0)});
  EXPECT_TRUE(story_.EventsOf(EventType::kRemoved, kGoodsClass).empty());
}

TEST_F(EvidenceMapperTest, ARestartInTheMiddleOfASessionChangesNothing) {
  MapStory restarted(PocdConfig(), BySession());
  // The side of the second thing is at a flat angle and waits for the end of the session.
  const testing::Scene scene = {
      FarWall(), Goods(0.0), Body(kGoodsClass, {1.2, 0.55, -0.3}, {2.2, 1.0, 0.3})};
  for (MapStory* story : {&story_, &restarted}) {
    story->Look(scene, kFrames / 2);
    if (story == &restarted) story->Restart();
    story->Look(scene, kFrames / 2);
    story->EndSession();
  }
  ExpectSameMap(story_.map(), restarted.map());
  EXPECT_EQ(story_.events(), restarted.events());
}

}  // namespace
}  // namespace steadymap
