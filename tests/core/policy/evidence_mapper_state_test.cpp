// The state of a map of the pocd policy: independent of commits and restarts, and told by deltas.

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/map/map_delta.h"
#include "core/mapper.h"
#include "core/policy/evidence_mapper.h"
#include "tests/core/policy/map_story.h"
#include "tests/support/analytic_scene.h"

namespace steadymap {
namespace {

using ::steadymap::testing::ExpectSameMap;
using ::steadymap::testing::FarWall;
using ::steadymap::testing::Goods;
using ::steadymap::testing::LookAtScene;
using ::steadymap::testing::MapStory;
using ::steadymap::testing::PocdConfig;
using ::steadymap::testing::Scene;
using ::steadymap::testing::SmallFrame;

/// Returns frames of a box that is added, moved and removed between visits, so that all decisions
/// but the last are made by a frame.
std::vector<Frame> EventfulFrames() {
  std::vector<Frame> frames;
  int visit = 0;
  for (const Scene& scene : {Scene{FarWall()},
                             Scene{FarWall(), Goods(-0.3)},
                             Scene{FarWall(), Goods(0.3)},
                             Scene{FarWall()},
                             Scene{FarWall()}}) {
    for (Frame& frame : LookAtScene(scene, static_cast<int>(frames.size()), 8, visit)) {
      frames.push_back(std::move(frame));
    }
    ++visit;
  }
  return frames;
}

/// Returns the commits for frames, one after every `frames_per_commit` frames.
std::vector<MapCommit> Commits(const std::vector<Frame>& frames, std::size_t frames_per_commit) {
  const std::unique_ptr<Mapper> mapper = Mapper::Create(PocdConfig()).value();
  std::vector<MapCommit> commits;
  for (const Frame& frame : frames) {
    mapper->Integrate(mapper->head().Next(), frame);
    if (mapper->uncommitted_entries() == frames_per_commit) commits.push_back(mapper->Commit());
  }
  return commits;
}

TEST(EvidenceMapperState, IsTheSameForAnyRhythmOfCommits) {
  const std::vector<Frame> frames = EventfulFrames();
  MapStory reference(PocdConfig());
  reference.Play(frames, 1);
  EXPECT_GE(reference.events().size(), 4U);
  for (const std::size_t frames_per_commit : {std::size_t{5}, frames.size()}) {
    SCOPED_TRACE(frames_per_commit);
    MapStory story(PocdConfig());
    story.Play(frames, frames_per_commit);
    EXPECT_EQ(story.events(), reference.events());
    ExpectSameMap(story.map(), reference.map());
  }
}

TEST(EvidenceMapperState, ARestartAfterAnyCommitChangesNothing) {
  const std::vector<Frame> frames = EventfulFrames();
  const std::vector<MapCommit> commits = Commits(frames, 4);
  MapSnapshot stored(commits.front().snapshot->scale);
  for (std::size_t i = 0; i + 1 < commits.size(); ++i) {
    ASSERT_TRUE(Apply(commits[i].delta, &stored).ok());
    ExpectSameMap(stored, *commits[i].snapshot);
    const std::unique_ptr<Mapper> restarted = Mapper::Create(PocdConfig()).value();
    restarted->Restore(stored);
    for (std::size_t frame = 4 * i + 4; frame < 4 * i + 8; ++frame) {
      restarted->Integrate(restarted->head().Next(), frames[frame]);
    }
    const MapCommit next = restarted->Commit();
    EXPECT_TRUE(next.delta == commits[i + 1].delta) << "restarted after commit " << i;
    ExpectSameMap(*next.snapshot, *commits[i + 1].snapshot);
  }
}

TEST(EvidenceMapperState, DeltasTellWhatSnapshotsShow) {
  const std::vector<MapCommit> commits = Commits(EventfulFrames(), 5);
  MapSnapshot before(commits.front().snapshot->scale);
  MapDelta all{.from = before.revision, .to = before.revision, .last_capture_time = {}};
  for (const MapCommit& commit : commits) {
    const MapDelta difference = Diff(before, *commit.snapshot);
    ASSERT_TRUE(Apply(difference, &before).ok());
    ExpectSameMap(before, *commit.snapshot);
    all = Merge(all, commit.delta);
  }
  MapSnapshot at_once(before.scale);
  ASSERT_TRUE(Apply(all, &at_once).ok());
  ExpectSameMap(at_once, *commits.back().snapshot);
  MapSnapshot nothing(before.scale);
  nothing.revision = at_once.revision.Next();
  ASSERT_TRUE(Apply(Diff(at_once, nothing), &at_once).ok());
  ExpectSameMap(at_once, nothing);
}

/// Reduces a frame to returns in a central patch of `side_px`.
Frame Patch(Frame frame, int side_px) {
  for (int v = 0; v < frame.camera.height_px; ++v) {
    for (int u = 0; u < frame.camera.width_px; ++u) {
      const int off_px = std::max(std::abs(u - frame.camera.width_px / 2),
                                  std::abs(v - frame.camera.height_px / 2));
      if (2 * off_px >= side_px) frame.depth.units.At(u, v) = kNoDepth;
    }
  }
  return frame;
}

TEST(EvidenceMapperState, IsPublishedWhenAFrameShowsLittleOfAnObject) {
  std::vector<Frame> frames = LookAtScene({FarWall(), Goods(0.0)}, 0, 7);
  const Frame whole = frames.back();
  for (int side_px = 8; side_px <= 32; side_px += 4) {
    SCOPED_TRACE(side_px);
    frames.back() = Patch(whole, side_px);
    MapStory step_by_step(PocdConfig());
    step_by_step.Play(frames, 1);
    step_by_step.EndSession();
    MapStory at_once(PocdConfig());
    at_once.Play(frames, frames.size());
    at_once.EndSession();
    ExpectSameMap(step_by_step.map(), at_once.map());
  }
}

TEST(EvidenceMapperState, IsWellFormedAfterFramesOfAnySizeAndDepth) {
  for (const auto& [width_px, height_px] :
       {std::pair{1, 1}, {2, 1}, {4, 4}, {1, 300}, {10, 10}, {14, 12}, {16, 16}, {37, 5}}) {
    for (const double depth_m : {0.0, 0.001, 1.0, 2.0, 2.9, 65.5}) {
      SCOPED_TRACE(::testing::Message() << width_px << " x " << height_px << " at " << depth_m);
      MapStory story(PocdConfig());
      for (int i = 0; i < 6; ++i) story.Play({SmallFrame(width_px, height_px, depth_m, i)});
      story.EndSession();
      EXPECT_EQ(story.map().revision, Revision(7));
      ExpectSameMap(story.told(), story.map());
    }
  }
}

}  // namespace
}  // namespace steadymap
