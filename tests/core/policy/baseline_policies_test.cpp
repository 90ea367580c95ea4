// Properties of all baseline policies: the same frames give the same map, independent of commits
// and restarts, and no surface of dynamic objects remains.

#include <string>

#include <gtest/gtest.h>

#include "tests/core/policy/map_story.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Around;
using ::steadymap::testing::Body;
using ::steadymap::testing::ConfigOf;
using ::steadymap::testing::CountSurfaceIn;
using ::steadymap::testing::ExpectSameMap;
using ::steadymap::testing::FarWall;
using ::steadymap::testing::Goods;
using ::steadymap::testing::kGoodsClass;
using ::steadymap::testing::kPersonClass;
using ::steadymap::testing::kWallClass;
using ::steadymap::testing::LookAtScene;
using ::steadymap::testing::MapStory;
using ::steadymap::testing::Scene;
using ::steadymap::testing::SceneBody;
using ::steadymap::testing::SmallFrame;

class BaselinePolicies : public ::testing::TestWithParam<UpdatePolicy> {};

/// Policies that, unlike the paper, do not take occluded surface for removed.
class PoliciesThatSeeDepth : public BaselinePolicies {};

/// Returns frames of two visits, in which a box is added, moved and removed.
std::vector<Frame> EventfulVisits() {
  std::vector<Frame> frames = LookAtScene({FarWall()}, 0, 6);
  const auto append = [&](const Scene& scene, int count, int visit) {
    for (Frame& frame : LookAtScene(scene, static_cast<int>(frames.size()), count, visit)) {
      frames.push_back(std::move(frame));
    }
  };
  append({FarWall(), Goods(-0.3)}, 14, 0);
  append({FarWall(), Goods(-0.2)}, 8, 0);
  append({FarWall(), Goods(0.3)}, 14, 1);
  append({FarWall()}, 14, 2);
  return frames;
}

TEST_P(BaselinePolicies, GiveTheSameMapWhateverTheCommitRhythm) {
  const std::vector<Frame> frames = EventfulVisits();
  MapStory reference(ConfigOf(GetParam()));
  reference.Play(frames, 1);
  EXPECT_FALSE(reference.events().empty());
  for (const std::size_t frames_per_commit : {std::size_t{4}, frames.size()}) {
    SCOPED_TRACE(frames_per_commit);
    MapStory story(ConfigOf(GetParam()));
    story.Play(frames, frames_per_commit);
    EXPECT_EQ(story.events(), reference.events());
    ExpectSameMap(story.map(), reference.map());
  }
}

TEST_P(BaselinePolicies, GoOnAfterARestartAsIfThereWereNone) {
  const std::vector<Frame> frames = EventfulVisits();
  MapStory reference(ConfigOf(GetParam()));
  reference.Play(frames, 1);
  MapStory story(ConfigOf(GetParam()));
  for (std::size_t i = 0; i < frames.size(); i += 4) {
    story.Play({frames.begin() + static_cast<std::ptrdiff_t>(i),
                frames.begin() + static_cast<std::ptrdiff_t>(std::min(i + 4, frames.size()))},
               3);
    story.Restart();
  }
  EXPECT_EQ(story.events(), reference.events());
  ExpectSameMap(story.map(), reference.map());
}

TEST_P(BaselinePolicies, KeepNothingOfAPerson) {
  const SceneBody person = Body(kPersonClass, {1.2, -0.2, -0.7}, {1.5, 0.2, 0.7});
  MapStory story(ConfigOf(GetParam()));
  story.Look({FarWall(), person}, 16);
  EXPECT_EQ(CountSurfaceIn(story.map(), Around(person, 0.2)), 0U);
  EXPECT_TRUE(story.EventsOf(EventType::kCreated, kPersonClass).empty());
}

TEST_P(PoliciesThatSeeDepth, KeepWhatIsHidden) {
  const SceneBody screen = Body(kWallClass, {0.9, -2.0, -2.0}, {1.1, 2.0, 2.0});
  MapStory story(ConfigOf(GetParam()));
  story.Look({FarWall(), Goods(0.0)}, 20);
  const Box front = Around(Goods(0.0), 0.05);
  const std::size_t surface = CountSurfaceIn(story.map(), front);
  EXPECT_GT(surface, 100U);
  story.Look({FarWall(), Goods(0.0), screen}, 20, /*visit=*/1);
  EXPECT_GE(CountSurfaceIn(story.map(), front), surface * 9 / 10);
}

TEST_P(BaselinePolicies, TakeFramesWithoutLabelsAsBackground) {
  std::vector<Frame> frames = LookAtScene({FarWall(), Goods(0.0)}, 0, 10);
  for (Frame& frame : frames) frame.labels = {};
  MapStory story(ConfigOf(GetParam()));
  story.Play(frames);
  EXPECT_TRUE(story.events().empty());
  EXPECT_GT(CountSurfaceIn(story.map(), Around(Goods(0.0), 0.05)), 100U);
  EXPECT_TRUE(story.Present(0).empty());
}

TEST_P(BaselinePolicies, TakeFramesOfAnySizeAndDepth) {
  for (const auto& [width_px, height_px] :
       {std::pair{1, 1}, {2, 1}, {1, 300}, {10, 10}, {16, 16}, {37, 5}}) {
    MapStory story(ConfigOf(GetParam()));
    int frames = 0;
    for (const double depth_m : {0.0, 0.001, 1.0, 2.0, 2.9, 65.5}) {
      for (int i = 0; i < 6; ++i, ++frames) {
        story.Play({SmallFrame(width_px, height_px, depth_m, frames)});
      }
    }
    EXPECT_EQ(story.map().revision, Revision(36));
  }
}

std::string NameOf(const ::testing::TestParamInfo<UpdatePolicy>& info) {
  switch (info.param) {
    case UpdatePolicy::kVoxelChange:
      return "VoxelChange";
    case UpdatePolicy::kSubmapChange:
      return "SubmapChange";
    case UpdatePolicy::kTracking:
      return "Tracking";
    case UpdatePolicy::kPocdPaper:
      return "PocdPaper";
    default:
      return "Other";
  }
}

INSTANTIATE_TEST_SUITE_P(,
                         BaselinePolicies,
                         ::testing::Values(UpdatePolicy::kVoxelChange,
                                           UpdatePolicy::kSubmapChange,
                                           UpdatePolicy::kTracking,
                                           UpdatePolicy::kPocdPaper),
                         NameOf);

INSTANTIATE_TEST_SUITE_P(,
                         PoliciesThatSeeDepth,
                         ::testing::Values(UpdatePolicy::kVoxelChange,
                                           UpdatePolicy::kSubmapChange,
                                           UpdatePolicy::kTracking),
                         NameOf);

}  // namespace
}  // namespace steadymap
