// A small scene for each switch of the pocd policy. Its result depends on the switch.

#include "core/policy/ablation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/mapper.h"
#include "core/policy/engine_parameters.h"
#include "tests/core/policy/map_story.h"
#include "tests/core/policy/room_drive.h"
#include "tests/support/analytic_scene.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Around;
using ::steadymap::testing::Body;
using ::steadymap::testing::ConfigOf;
using ::steadymap::testing::CountSurfaceIn;
using ::steadymap::testing::Drive;
using ::steadymap::testing::ExpectSameMap;
using ::steadymap::testing::FarWall;
using ::steadymap::testing::Goods;
using ::steadymap::testing::kGoodsClass;
using ::steadymap::testing::kPersonClass;
using ::steadymap::testing::kWallClass;
using ::steadymap::testing::LookAtScene;
using ::steadymap::testing::MapStory;
using ::steadymap::testing::Mislead;
using ::steadymap::testing::RenderScene;
using ::steadymap::testing::Room;
using ::steadymap::testing::Scene;
using ::steadymap::testing::SceneBody;
using ::steadymap::testing::WithReach;

constexpr std::uint16_t kCeilingLabel = 2;
constexpr std::uint16_t kShelfLabel = 6;

/// Returns a map of the pocd policy with all switches on except `name`; an empty name leaves all
/// on.
MapStory StoryWithout(const std::string& name) {
  MapperOptions options;
  if (!name.empty()) options.switches = AllOnBut(name).value();
  return MapStory(ConfigOf(UpdatePolicy::kPocd), options);
}

/// Returns the results of `tell` with all switches on, and without the switch `name`.
template <typename Tell>
auto WithAndWithout(const std::string& name, Tell tell) {
  MapStory with = StoryWithout("");
  MapStory without = StoryWithout(name);
  auto first = tell(&with);
  return std::pair(std::move(first), tell(&without));
}

std::size_t CountEvents(const MapStory& story, EventType type, std::uint16_t label) {
  return story.EventsOf(type, label).size();
}

TEST(Ablation, EveryOneHasANameAndTurnsOffOneThing) {
  std::set<std::string> names;
  const Ablation all;
  for (const AblationSwitch& row : AllAblationSwitches()) {
    SCOPED_TRACE(std::string(row.name));
    EXPECT_TRUE(names.emplace(row.name).second);
    EXPECT_FALSE(row.off.empty());
    Ablation switches = AllOnBut(std::string(row.name)).value();
    EXPECT_FALSE(switches.*row.is_on);
    switches.*row.is_on = true;
    EXPECT_TRUE(switches == all);
  }
  EXPECT_EQ(names.size(), sizeof(Ablation)) << "a switch is missing in the list";
}

TEST(Ablation, AnUnknownNameIsAnErrorThatListsThem) {
  const absl::Status status = AllOnBut("everything").status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_NE(status.message().find("everything"), absl::string_view::npos) << status;
  EXPECT_NE(status.message().find("robot-guard"), absl::string_view::npos) << status;
}

TEST(Ablation, OtherPoliciesHaveNone) {
  Ablation none;
  for (const AblationSwitch& row : AllAblationSwitches()) none.*row.is_on = false;
  const SceneBody person = Body(kPersonClass, {1.2, -0.2, -0.7}, {1.5, 0.2, 0.7});
  for (const UpdatePolicy policy :
       {UpdatePolicy::kStatic, UpdatePolicy::kTracking, UpdatePolicy::kPocdPaper}) {
    MapStory plain(ConfigOf(policy));
    MapStory switched(ConfigOf(policy), {.switches = none});
    plain.Look({FarWall(), Goods(0.3), person}, 6);
    switched.Look({FarWall(), Goods(0.3), person}, 6);
    ExpectSameMap(plain.map(), switched.map());
  }
}

TEST(Ablation, WithoutVisibilityByDepthAHiddenBoxIsRemoved) {
  const SceneBody rack = Body(kShelfLabel, {0.9, -2.0, -2.0}, {1.1, 2.0, 2.0});
  const auto [with, without] = WithAndWithout("visibility", [&](MapStory* story) {
    story->Look({FarWall(), Goods(0.0)}, 12);
    story->Look({FarWall(), Goods(0.0), rack}, 12);
    return CountEvents(*story, EventType::kRemoved, kGoodsClass);
  });
  EXPECT_EQ(with, 0U);
  EXPECT_EQ(without, 1U);
}

/// Returns frames along a wall of `length_m` from one end to the other, at a distance of 1.5 m.
std::vector<Frame> DriveAlongWall(double length_m) {
  const SceneBody wall = Body(kWallClass, {1.5, 0.0, -1.0}, {1.6, length_m, 1.0});
  std::vector<Frame> frames;
  for (int i = 0; i <= 40; ++i) {
    const double y_m = length_m * i / 40.0;
    frames.push_back(RenderScene({wall},
                                 {.eye_world = {0.0, y_m, 0.0},
                                  .target_world = {1.5, y_m, 0.0},
                                  .capture_time_s = 100.0 + 0.5 * i}));
  }
  return frames;
}

TEST(Ablation, WithoutTheCuboidGateAWallSeenInPiecesFallsApart) {
  const auto [with, without] = WithAndWithout("cuboid-gate", [](MapStory* story) {
    story->Play(DriveAlongWall(6.0));
    return CountEvents(*story, EventType::kCreated, kWallClass);
  });
  EXPECT_EQ(with, 1U);
  EXPECT_GT(without, 1U);
}

TEST(Ablation, WithoutManyToOneAWallThatComesIntoViewBitByBitIsNeverKnown) {
  const auto [with, without] = WithAndWithout("many-to-one", [](MapStory* story) {
    story->Play(DriveAlongWall(3.0));
    return story->Present(kWallClass).size();
  });
  EXPECT_EQ(with, 1U);
  EXPECT_EQ(without, 0U);
}

TEST(Ablation, WithoutMergingTwoPiecesOfOneThingStayTwo) {
  const SceneBody post = Body(kShelfLabel, {1.0, -0.12, -1.0}, {1.1, 0.12, 1.0});
  const SceneBody wide = Body(kGoodsClass, {1.6, -0.6, -0.3}, {2.0, 0.6, 0.3});
  const auto [with, without] = WithAndWithout("merging", [&](MapStory* story) {
    story->Look({FarWall(), post, wide}, 6);
    story->Look({FarWall(), wide}, 20);
    return story->Present(kGoodsClass).size();
  });
  EXPECT_EQ(with, 1U);
  EXPECT_EQ(without, 2U);
}

/// Returns a pile with its top at `top_m`.
SceneBody PileUpTo(double top_m) { return Body(kGoodsClass, {1.6, -0.4, -0.8}, {2.0, 0.4, top_m}); }

TEST(Ablation, WithoutSplittingAPileKeepsThePartThatWasTakenAway) {
  const Box taken = Box(Eigen::Vector3d(1.4, -0.5, 0.3), Eigen::Vector3d(2.2, 0.5, 0.8));
  const auto [with, without] = WithAndWithout("splitting", [&](MapStory* story) {
    story->Look({FarWall(), PileUpTo(0.6)}, 20);
    story->Look({FarWall(), PileUpTo(0.2)}, 15, 1);
    return std::pair(CountEvents(*story, EventType::kSplit, kGoodsClass),
                     CountSurfaceIn(story->map(), taken));
  });
  EXPECT_EQ(with.first, 1U);
  EXPECT_EQ(with.second, 0U);
  EXPECT_EQ(without.first, 0U);
  EXPECT_GT(without.second, 0U);
}

TEST(Ablation, WithoutTheArchiveWhatIsRemovedIsForgotten) {
  const auto [with, without] = WithAndWithout("archive", [](MapStory* story) {
    story->Look({FarWall(), Goods(0.0)}, 12);
    story->Look({FarWall()}, 10, 1);
    EXPECT_EQ(CountEvents(*story, EventType::kRemoved, kGoodsClass), 1U);
    EXPECT_TRUE(story->Present(kGoodsClass).empty());
    ExpectSameMap(story->told(), story->map());
    return story->map().objects.size();
  });
  EXPECT_EQ(with, 2U);
  EXPECT_EQ(without, 1U) << "the wall";
}

TEST(Ablation, WithoutReturningABoxThatComesBackIsANewOne) {
  const auto [with, without] = WithAndWithout("returning", [](MapStory* story) {
    story->Look({FarWall(), Goods(0.0)}, 12);
    story->Look({FarWall()}, 12, 1);
    // Too few frames for re-identification by shape at another position.
    story->Look({FarWall(), Goods(0.0)}, 6, 2);
    return std::pair(CountEvents(*story, EventType::kReturned, kGoodsClass),
                     CountEvents(*story, EventType::kCreated, kGoodsClass));
  });
  EXPECT_EQ(with, std::pair(std::size_t{1}, std::size_t{1}));
  EXPECT_EQ(without, std::pair(std::size_t{0}, std::size_t{2}));
}

TEST(Ablation, WithoutMovesABoxGoesHereAndComesThere) {
  const auto [with, without] = WithAndWithout("moves", [](MapStory* story) {
    story->Look({FarWall(), Goods(-0.3)}, 12);
    story->Look({FarWall(), Goods(0.3)}, 20, 1);
    return std::pair(CountEvents(*story, EventType::kMoved, kGoodsClass),
                     CountEvents(*story, EventType::kRemoved, kGoodsClass));
  });
  EXPECT_EQ(with.first, 1U);
  EXPECT_EQ(without, std::pair(std::size_t{0}, std::size_t{1}));
}

TEST(Ablation, WithoutTheGuardALostRobotSpoilsTheMap) {
  const auto [with, without] = WithAndWithout("robot-guard", [](MapStory* story) {
    story->Play(Drive(Room(), 0, 70));
    const std::size_t objects = story->map().objects.size();
    story->Play(Mislead(Drive(Room(), 70, 12), 1.0, 0.52));
    return story->map().objects.size() - objects;
  });
  EXPECT_EQ(with, 0U);
  EXPECT_GT(without, 0U);
}

/// Returns frames of a box that appears rotated in place by `yaw_rad`.
std::vector<Frame> LookAtBoxTurnedBy(double yaw_rad, int first, int count) {
  const Eigen::Vector3d center_world = Goods(0.0).box_world.center();
  const Eigen::Isometry3d turn = Eigen::Translation3d(center_world) *
                                 Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()) *
                                 Eigen::Translation3d(-center_world);
  std::vector<Frame> frames = LookAtScene({Goods(0.0)}, first, count);
  for (Frame& frame : frames) frame.T_world_camera = turn * frame.T_world_camera;
  return frames;
}

TEST(Ablation, WithoutTurningABoxThatWasTurnedGoesUnnoticed) {
  const auto [with, without] = WithAndWithout("turning", [](MapStory* story) {
    story->Look({Goods(0.0)}, 30);
    story->Play(LookAtBoxTurnedBy(0.22, 30, 30));
    return CountEvents(*story, EventType::kRemoved, kGoodsClass);
  });
  EXPECT_EQ(with, 1U);
  EXPECT_EQ(without, 0U);
}

TEST(Ablation, WithoutReplacingAWallThatCameCloserIsThereTwice) {
  const auto panel = [](double x_m) {
    return Body(kWallClass, {x_m, -0.8, -0.7}, {x_m + 0.05, 0.8, 0.7});
  };
  const auto [with, without] = WithAndWithout("replacing", [&](MapStory* story) {
    story->Look({panel(2.2)}, 15);
    story->Look({panel(1.95)}, 30, 1);
    return CountSurfaceIn(story->map(), Around(panel(2.2), 0.1));
  });
  EXPECT_EQ(with, 0U);
  EXPECT_GT(without, 0U);
}

TEST(Ablation, WithoutFreeSpaceAThingThatIsPutBesideOneIsMoreOfIt) {
  const SceneBody left = Body(kGoodsClass, {1.6, -0.5, -0.3}, {2.0, 0.0, 0.3});
  const SceneBody right = Body(kGoodsClass, {1.6, 0.0, -0.3}, {2.0, 0.5, 0.3});
  const auto [with, without] = WithAndWithout("free-space", [&](MapStory* story) {
    story->Look({FarWall(), left}, 15);
    story->Look({FarWall(), left, right}, 10, 1);
    return story->Present(kGoodsClass).size();
  });
  EXPECT_EQ(with, 2U);
  EXPECT_EQ(without, 1U);
}

TEST(Ablation, WithoutTentativeObjectsOneFrameIsEnough) {
  const auto [with, without] = WithAndWithout("tentative", [](MapStory* story) {
    story->Look({FarWall(), Goods(0.0)}, 1);
    return story->Present(kGoodsClass).size();
  });
  EXPECT_EQ(with, 0U);
  EXPECT_EQ(without, 1U);
}

TEST(Ablation, WithoutGatheringALittleSurfaceChangesABeliefSooner) {
  const SceneBody post = Body(kShelfLabel, {1.6, -0.03, -0.5}, {1.66, 0.03, 0.3});
  const auto [with, without] = WithAndWithout("gathering", [&](MapStory* story) {
    story->Look({FarWall(), post}, 8);
    double evidence = 0.0;
    for (const auto& [id, object] : story->map().objects) {
      if (object->class_id != ClassId(kShelfLabel)) continue;
      evidence = std::max(evidence, object->belief.alpha + object->belief.beta);
    }
    return evidence;
  });
  EXPECT_LT(with, without);
}

TEST(Ablation, WithoutACapEvidenceGrowsWithoutBound) {
  const auto [with, without] = WithAndWithout("evidence-cap", [](MapStory* story) {
    story->Look({FarWall(), Goods(0.0)}, 40);
    const Belief belief = story->Present(kGoodsClass)[0]->belief;
    return belief.alpha + belief.beta;
  });
  EXPECT_LE(with, StationarityParameters().max_evidence + 1.0);
  EXPECT_GT(without, 2.0 * StationarityParameters().max_evidence);
}

TEST(Ablation, WithoutACleanChangeNoiseIsTakenForOne) {
  const auto [with, without] = WithAndWithout("clean-change", [](MapStory* story) {
    story->Look({FarWall(), Goods(0.0)}, 15);
    return std::abs(story->Present(kGoodsClass)[0]->belief.change_mean_m);
  });
  EXPECT_LT(with, without);
  EXPECT_GT(without, 0.0);
}

TEST(Ablation, WithoutTheDynamicMaskAPersonIsInTheMap) {
  const SceneBody person = Body(kPersonClass, {1.2, -0.2, -0.7}, {1.5, 0.2, 0.7});
  const auto [with, without] = WithAndWithout("dynamic-mask", [&](MapStory* story) {
    story->Look({FarWall(), person}, 10);
    return CountSurfaceIn(story->map(), Around(person, 0.05));
  });
  EXPECT_EQ(with, 0U);
  EXPECT_GT(without, 0U);
}

TEST(Ablation, WithoutFarLabelsWhatStoodBeforeTheReachOfDepthStays) {
  const SceneBody shelf = Body(kShelfLabel, {6.0, -5.0, -5.0}, {6.3, 5.0, 5.0});
  const SceneBody floor = Body(kCeilingLabel, {1.0, -5.0, -1.5}, {3.0, 5.0, -1.0});
  const auto [with, without] = WithAndWithout("far-labels", [&](MapStory* story) {
    const auto look = [&](const Scene& scene, int visit) {
      for (const Frame& frame : LookAtScene(scene, 20 * visit, 20, visit)) {
        story->Play({WithReach(frame, 5.0)});
      }
    };
    look({shelf, floor, Goods(0.0)}, 0);
    EXPECT_EQ(story->Present(kGoodsClass).size(), 1U);
    look({shelf, floor}, 1);
    return story->Present(kGoodsClass).size();
  });
  EXPECT_EQ(with, 0U);
  EXPECT_EQ(without, 1U);
}

TEST(Ablation, WithoutTheMovingMemoryAWrongLabelLeavesATrail) {
  const auto person = [](std::uint16_t label) {
    return Body(label, {1.2, -0.2, -0.7}, {1.5, 0.2, 0.7});
  };
  const auto [with, without] = WithAndWithout("moving-memory", [&](MapStory* story) {
    for (int i = 0; i < 6; ++i) {
      const std::uint16_t label = i == 4 ? kCeilingLabel : kPersonClass;
      story->Play({RenderScene({FarWall(), person(label)}, {.capture_time_s = 100.0 + 0.1 * i})});
    }
    return CountSurfaceIn(story->map(), Around(person(kPersonClass), 0.05));
  });
  EXPECT_EQ(with, 0U);
  EXPECT_GT(without, 0U);
}

}  // namespace
}  // namespace steadymap
