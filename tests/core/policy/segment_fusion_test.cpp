#include "core/policy/segment_fusion.h"

#include <gtest/gtest.h>

#include "core/association/segmentation.h"
#include "tests/core/policy/map_story.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Body;
using ::steadymap::testing::FarWall;
using ::steadymap::testing::Goods;
using ::steadymap::testing::kGoodsClass;
using ::steadymap::testing::kWallClass;
using ::steadymap::testing::LookAtScene;
using ::steadymap::testing::Scene;

/// A map into which segments are fused, frame by frame.
class SegmentFusionTest : public ::testing::Test {
 protected:
  /// Matches the next frame of a scene with all objects and fuses it.
  void See(const Scene& scene) {
    Match(scene);
    fusion_.AddObjects();
    fusion_.Fuse();
    map_.EndFrame();
  }

  void Match(const Scene& scene) {
    const int frame = static_cast<int>(map_.revision().value());
    cloud_.Compute(LookAtScene(scene, frame, 1).front());
    map_.BeginFrame(map_.revision().Next(), Timestamp::FromSeconds(frame));
    fusion_.Match(map_.AllObjects(), &cloud_, &map_);
  }

  /// Returns the number of samples of the frame that match objects of a class.
  std::size_t SamplesOf(std::uint16_t label) const {
    std::size_t samples = 0;
    for (std::size_t place = 0; place < fusion_.in_view().size(); ++place) {
      if (fusion_.in_view()[place].object->state().class_id == ClassId(label)) {
        samples += fusion_.CountSamples(place);
      }
    }
    return samples;
  }

  MapConfig config_;
  SemanticCloud cloud_{config_};
  WorkingMap map_{config_};
  SegmentFusion fusion_{config_, SegmentFusionParameters{}};
};

TEST_F(SegmentFusionTest, MakesAnObjectOfEachSegmentOnce) {
  const Scene scene = {FarWall(), Goods(-0.5), Goods(0.5)};
  for (int i = 0; i < 4; ++i) See(scene);
  ASSERT_EQ(map_.objects().size(), 3U);
  for (const auto& [id, object] : map_.objects()) EXPECT_GT(object.surface().point_count(), 50U);
}

TEST_F(SegmentFusionTest, MatchesOneObjectWithAllItsParts) {
  See({FarWall()});
  // A post divides the visible wall in two.
  const Scene scene = {FarWall(), Body(kGoodsClass, {1.5, -0.1, -3.0}, {1.6, 0.1, 3.0})};
  See(scene);
  EXPECT_EQ(map_.objects().size(), 2U);
  Match(scene);
  EXPECT_EQ(fusion_.PointsOf(0).size(), fusion_.CountSamples(0));
  EXPECT_GT(SamplesOf(kWallClass), 2000U);
}

TEST_F(SegmentFusionTest, MatchesNothingOfAnotherClassOrElsewhere) {
  See({Goods(0.0)});
  Match({Body(kWallClass, {1.6, -0.25, -0.3}, {2.0, 0.25, 0.3})});
  EXPECT_EQ(SamplesOf(kGoodsClass), 0U) << "another class";
  map_.EndFrame();
  Match({Goods(0.0, 2.0)});
  EXPECT_EQ(SamplesOf(kGoodsClass), 0U) << "further away";
  map_.EndFrame();
  Match({Goods(0.0)});
  EXPECT_GT(SamplesOf(kGoodsClass), 200U);
}

TEST_F(SegmentFusionTest, CountsNothingAgainstAnObjectThatIsHidden) {
  See({FarWall(), Goods(0.0)});
  // Three quarters of the box are occluded by a screen.
  Match({FarWall(), Goods(0.0), Body(6, {1.0, -2.0, -2.0}, {1.05, 0.06, 2.0})});
  EXPECT_GT(SamplesOf(kGoodsClass), 20U);
}

TEST_F(SegmentFusionTest, FusesNeitherSmallSegmentsNorReleasedOnes) {
  See({FarWall(), Body(kGoodsClass, {2.0, -0.05, -0.05}, {2.1, 0.05, 0.05})});
  EXPECT_EQ(map_.objects().size(), 1U);
  Match({FarWall()});
  fusion_.Release(0);
  EXPECT_EQ(fusion_.CountSamples(0), 0U);
  EXPECT_TRUE(fusion_.PointsOf(0).empty());
}

TEST_F(SegmentFusionTest, PutsTheGroundIntoTheBackgroundWhateverItsLabel) {
  for (int i = 0; i < 3; ++i) {
    See({Body(kWallClass, {-5.0, -5.0, -1.0}, {9.0, 5.0, -0.5}), Goods(0.0)});
  }
  EXPECT_GT(map_.background().CountObservedVoxels(), 1000U);
  for (const auto& [id, object] : map_.objects()) {
    EXPECT_EQ(object.state().class_id, ClassId(kGoodsClass));
  }
}

}  // namespace
}  // namespace steadymap
