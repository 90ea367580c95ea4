// A person in front of a wall. Some frames assign another class to the person.

#include "core/robot/dynamic_mask.h"

#include <cstddef>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/core/policy/map_story.h"
#include "tests/support/analytic_scene.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Around;
using ::steadymap::testing::Body;
using ::steadymap::testing::CountSurfaceIn;
using ::steadymap::testing::ExpectSameMap;
using ::steadymap::testing::FarWall;
using ::steadymap::testing::FinePocdConfig;
using ::steadymap::testing::kGoodsClass;
using ::steadymap::testing::kPersonClass;
using ::steadymap::testing::kWallClass;
using ::steadymap::testing::MapStory;
using ::steadymap::testing::PocdConfig;
using ::steadymap::testing::RenderScene;
using ::steadymap::testing::SceneBody;

constexpr std::uint16_t kCeilingClass = 2;  // Fused into the background at once.

/// Returns a person with class `label`, centred at `y`.
SceneBody Person(std::uint16_t label, double y = 0.0) {
  return Body(label, {1.2, y - 0.2, -0.7}, {1.5, y + 0.2, 0.7});
}

class MovingSurfaceTest : public ::testing::Test {
 protected:
  explicit MovingSurfaceTest(const MapConfig& config = PocdConfig())
      : moving_(config, {}), cloud_(config), map_(config) {}

  /// Returns the number of cells of class `label` that a frame would fuse.
  std::size_t See(const std::vector<SceneBody>& scene,
                  std::uint16_t label,
                  double time_s,
                  const std::string& robot = "robot") {
    const Frame frame = RenderScene(scene, {.capture_time_s = 100.0 + time_s});
    cloud_.Compute(frame);
    map_.BeginFrame(map_.revision().Next(), frame.capture_time);
    moving_.Apply({robot, SensorName::kDefaultSensor}, map_, &cloud_);
    moving_.Record({robot, SensorName::kDefaultSensor}, cloud_, &map_);
    map_.EndFrame();
    std::size_t count = 0;
    for (int row = 0; row < cloud_.cells_high(); ++row) {
      for (int column = 0; column < cloud_.cells_wide(); ++column) {
        const bool is_fused = cloud_.At(column, row).weight > 0.0F;
        count += is_fused && cloud_.LabelAt(column, row) == label ? 1U : 0U;
      }
    }
    return count;
  }

  /// Returns the number of cells of the person that a frame would fuse, if it labels the person
  /// `label`.
  std::size_t SeePerson(std::uint16_t label, double time_s, const std::string& robot = "robot") {
    return See({FarWall(), Person(label)}, label, time_s, robot);
  }

  DynamicMask moving_;
  SemanticCloud cloud_;
  WorkingMap map_;
};

TEST_F(MovingSurfaceTest, HidesWhatMovedAMomentAgoWhateverItIsCalled) {
  SeePerson(kPersonClass, 0.0);
  SeePerson(kPersonClass, 0.1);
  EXPECT_EQ(SeePerson(kGoodsClass, 0.2), 0U);
  EXPECT_EQ(SeePerson(kGoodsClass, 0.5), 0U) << "though the last frame did not know it";
  EXPECT_GT(See({FarWall(), Person(kPersonClass)}, kWallClass, 0.6), 1000U);
}

TEST_F(MovingSurfaceTest, HidesNothingOfAThingThatOneFrameTookForAPerson) {
  SeePerson(kGoodsClass, 0.0);
  SeePerson(kPersonClass, 0.1);
  EXPECT_GT(SeePerson(kGoodsClass, 0.2), 500U);
}

TEST_F(MovingSurfaceTest, FollowsAPersonWhoWalks) {
  for (int i = 0; i < 6; ++i) {
    See({FarWall(), Person(kPersonClass, 0.1 * i)}, kPersonClass, 0.1 * i);
  }
  const std::size_t before = See({FarWall(), Person(kGoodsClass, 0.6)}, kGoodsClass, 10.0);
  for (int i = 0; i < 6; ++i) {
    See({FarWall(), Person(kPersonClass, 0.1 * i)}, kPersonClass, 20.0 + 0.1 * i);
  }
  EXPECT_LT(See({FarWall(), Person(kGoodsClass, 0.6)}, kGoodsClass, 20.6), before / 2);
}

TEST_F(MovingSurfaceTest, ForgetsSoonAfterwards) {
  SeePerson(kPersonClass, 0.0);
  SeePerson(kPersonClass, 0.1);
  EXPECT_GT(SeePerson(kGoodsClass, 1.2), 500U);
  EXPECT_TRUE(map_.FindRobot({"robot", SensorName::kDefaultSensor})->moving.empty());
}

TEST_F(MovingSurfaceTest, FramesFarApartConfirmNothing) {
  SeePerson(kPersonClass, 0.0);
  SeePerson(kPersonClass, 1.1);
  EXPECT_GT(SeePerson(kGoodsClass, 1.2), 500U);
}

TEST_F(MovingSurfaceTest, FramesThatComeLateAreNotWhatTheMomentShows) {
  SeePerson(kPersonClass, 10.0);
  SeePerson(kPersonClass, 10.1);
  EXPECT_GT(SeePerson(kGoodsClass, 0.0), 500U);
}

TEST_F(MovingSurfaceTest, EachRobotRemembersWhatItSaw) {
  SeePerson(kPersonClass, 0.0, "one");
  SeePerson(kPersonClass, 0.1, "one");
  EXPECT_GT(SeePerson(kGoodsClass, 0.2, "other"), 500U);
  EXPECT_EQ(SeePerson(kGoodsClass, 0.2, "one"), 0U);
  EXPECT_EQ(map_.FindRobot({"other", SensorName::kDefaultSensor}), nullptr)
      << "it has seen nothing to remember";
}

class FineMovingSurfaceTest : public MovingSurfaceTest {
 protected:
  FineMovingSurfaceTest() : MovingSurfaceTest(FinePocdConfig()) {}
};

TEST_F(FineMovingSurfaceTest, ACameraThatSeesNothingButPeopleFillsNoMemory) {
  const SceneBody crowd = Body(kPersonClass, {2.6, -4.0, -3.0}, {3.0, 4.0, 3.0});
  See({crowd}, kPersonClass, 0.0);
  See({crowd}, kPersonClass, 0.1);
  const std::vector<MovingCell>& moving =
      map_.FindRobot({"robot", SensorName::kDefaultSensor})->moving;
  EXPECT_EQ(moving.size(), 4096U);
  for (std::size_t i = 1; i < moving.size(); ++i) {
    EXPECT_LT(moving[i - 1].cell, moving[i].cell);
  }
}

TEST(DynamicMask, AWrongLabelLeavesNoTrailWhereverARestartFalls) {
  const auto take = [](MapStory* story, int first, int count, std::uint16_t label) {
    std::vector<Frame> frames;
    for (int i = first; i < first + count; ++i) {
      frames.push_back(
          RenderScene({FarWall(), Person(label)}, {.capture_time_s = 100.0 + 0.1 * i}));
    }
    story->Play(frames, 2);
  };
  MapStory story(PocdConfig());
  MapStory restarted(PocdConfig());
  for (MapStory* told : {&story, &restarted}) {
    take(told, 0, 5, kPersonClass);
    if (told == &restarted) told->Restart();
    take(told, 5, 1, kCeilingClass);
    take(told, 6, 4, kPersonClass);
  }
  EXPECT_EQ(CountSurfaceIn(story.map(), Around(Person(kPersonClass), 0.1)), 0U);
  EXPECT_FALSE(story.map().robots.at({"robot", "camera"}).moving.empty());
  ExpectSameMap(restarted.map(), story.map());
  ExpectSameMap(story.told(), story.map());
}

}  // namespace
}  // namespace steadymap
