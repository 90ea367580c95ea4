#include "core/mapper.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/map/map_counts.h"
#include "core/map/map_delta.h"
#include "core/query/vdb_file.h"
#include "core/volume/leaf_patch.h"
#include "core/volume/tsdf_mesh.h"
#include "tests/core/policy/room_drive.h"
#include "tests/support/all_policies.h"
#include "tests/support/analytic_depth.h"

namespace steadymap {
namespace {

using ::steadymap::testing::AnalyticCamera;
using ::steadymap::testing::LookAt;
using ::steadymap::testing::RenderAnalytic;
using ::steadymap::testing::Sphere;

/// Returns frames of a sphere from poses on a circle, so that later frames update old and new
/// leaves.
std::vector<Frame> CircleFrames(int count) {
  const Eigen::Vector3d center(0.1, 0.2, 0.3);
  std::vector<Frame> frames;
  for (int i = 0; i < count; ++i) {
    const double angle = 0.4 * i;
    const Eigen::Vector3d eye =
        center + Eigen::Vector3d(1.8 * std::cos(angle), 1.8 * std::sin(angle), 0.2);
    frames.push_back(RenderAnalytic(Sphere(center, 0.5), AnalyticCamera(), LookAt(eye, center)));
    frames.back().capture_time = Timestamp::FromNanoseconds(std::int64_t{1'000'000} * (i + 1));
  }
  return frames;
}

/// Returns a frame of a wall perpendicular to the optical axis.
Frame WallFrame(int depth_mm) {
  Frame frame;
  frame.camera = AnalyticCamera();
  frame.depth.units = Image<std::uint16_t>(
      frame.camera.width_px, frame.camera.height_px, static_cast<std::uint16_t>(depth_mm));
  return frame;
}

/// Returns the number of background voxels that were observed before and have changed.
std::size_t CountChangedVoxels(const MapSnapshot& before, const MapSnapshot& after) {
  std::size_t count = 0;
  after.background.ForEachLeaf([&](LeafOrigin origin, const LeafView& leaf) {
    const LeafView old = before.background.FindLeaf(origin);
    if (!old) return;
    const auto patch = FindLeafPatch(old, leaf);
    ASSERT_TRUE(patch.has_value());
    for (std::size_t word = 0; word < old.observed.size(); ++word) {
      count += static_cast<std::size_t>(std::popcount(patch->observed[word] & old.observed[word]));
    }
  });
  return count;
}

std::unique_ptr<Mapper> NewMapper() { return Mapper::Create(MapConfig()).value(); }

std::string Vdb(const MapSnapshot& snapshot) { return WriteVdb(snapshot, nullptr).value(); }

/// Integrates all frames, with a commit after every `frames_per_commit` frames.
std::vector<MapCommit> Map(const std::vector<Frame>& frames, std::size_t frames_per_commit) {
  const std::unique_ptr<Mapper> mapper = NewMapper();
  std::vector<MapCommit> commits;
  for (const Frame& frame : frames) {
    mapper->Integrate(mapper->head().Next(), frame);
    if (mapper->uncommitted_entries() == frames_per_commit) commits.push_back(mapper->Commit());
  }
  if (mapper->uncommitted_entries() > 0) commits.push_back(mapper->Commit());
  return commits;
}

TEST(Mapper, RefusesAnImpossibleConfiguration) {
  MapConfig config;
  config.voxel_size_m = -0.02;
  const absl::Status status = Mapper::Create(config).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_NE(status.message().find("voxel_size_m must lie in [0.001, 1], got -0.02"),
            absl::string_view::npos)
      << status;
}

TEST(Mapper, GivesTheSameMapWhereverCommitsFall) {
  const std::vector<Frame> frames = CircleFrames(12);
  const std::string reference = Vdb(*Map(frames, 1).back().snapshot);
  EXPECT_GT(reference.size(), 10'000U);
  for (const std::size_t frames_per_commit : {2U, 5U, 12U}) {
    EXPECT_EQ(Vdb(*Map(frames, frames_per_commit).back().snapshot), reference);
  }
}

TEST(Mapper, GoesOnFromARestoredMapAsIfNeverStopped) {
  const std::vector<Frame> frames = CircleFrames(12);
  const std::string reference = Vdb(*Map(frames, 4).back().snapshot);

  MapSnapshot restored({MapConfig().voxel_size_m, MapConfig().truncation_m});
  for (const MapCommit& commit : Map({frames.begin(), frames.begin() + 7}, 3)) {
    ASSERT_TRUE(Apply(commit.delta, &restored).ok());
  }
  const std::unique_ptr<Mapper> mapper = NewMapper();
  mapper->Restore(restored);
  EXPECT_EQ(mapper->head(), MapSequence(7));
  for (std::size_t i = 7; i < frames.size(); ++i) {
    mapper->Integrate(mapper->head().Next(), frames[i]);
  }
  EXPECT_EQ(Vdb(*mapper->Commit().snapshot), reference);
}

TEST(Mapper, NeverTouchesASnapshotItHandedOut) {
  const std::vector<Frame> frames = CircleFrames(8);
  const std::unique_ptr<Mapper> mapper = NewMapper();
  mapper->Integrate(MapSequence(1), frames[0]);
  const MapCommit first = mapper->Commit();
  const std::string before = Vdb(*first.snapshot);
  for (std::size_t i = 1; i < frames.size(); ++i) {
    mapper->Integrate(mapper->head().Next(), frames[i]);
  }
  const MapCommit last = mapper->Commit();
  EXPECT_EQ(Vdb(*first.snapshot), before);
  EXPECT_NE(Vdb(*last.snapshot), before);
}

TEST(Mapper, RevisionIsTheNewestFrame) {
  const std::vector<MapCommit> commits = Map(CircleFrames(7), 3);
  ASSERT_EQ(commits.size(), 3U);
  EXPECT_EQ(commits[0].delta.from, Revision(0));
  EXPECT_EQ(commits[0].delta.to, Revision(3));
  EXPECT_EQ(commits[1].delta.from, Revision(3));
  EXPECT_EQ(commits[2].delta.to, Revision(7));
  EXPECT_EQ(commits[2].snapshot->revision, Revision(7));
  EXPECT_EQ(commits[2].snapshot->last_capture_time, Timestamp::FromNanoseconds(7'000'000));
}

TEST(Mapper, StopsChangingAPlaceThatStaysTheSame) {
  const Frame frame = CircleFrames(1)[0];
  const std::unique_ptr<Mapper> mapper = NewMapper();
  for (int i = 0; i < 50; ++i) mapper->Integrate(mapper->head().Next(), frame);
  mapper->Commit();
  mapper->Integrate(mapper->head().Next(), frame);
  const MapCommit commit = mapper->Commit();
  EXPECT_TRUE(commit.delta.leaves.empty());
  EXPECT_EQ(commit.snapshot->revision, Revision(51));
}

TEST(Mapper, StopsChangingAPlaceSeenWithNoise) {
  std::mt19937 random(4);
  std::uniform_int_distribution<int> noise(-6, 6);
  const std::unique_ptr<Mapper> mapper = NewMapper();
  const auto look = [&] {
    Frame frame = WallFrame(2000);
    std::uint16_t* units = frame.depth.units.data();
    const int pixels = frame.camera.width_px * frame.camera.height_px;
    std::for_each(units, units + pixels, [&](std::uint16_t& unit) {
      unit = static_cast<std::uint16_t>(unit + noise(random));
    });
    mapper->Integrate(mapper->head().Next(), frame);
    return mapper->Commit();
  };
  std::shared_ptr<const MapSnapshot> before;
  for (int i = 0; i < 60; ++i) before = look().snapshot;
  const MapCommit commit = look();
  EXPECT_LT(CountChangedVoxels(*before, *commit.snapshot), CountMap(*commit.snapshot).voxels / 50);
}

TEST(Mapper, SettlesNearTheCameraTooWhereALookWeighsMuch) {
  // No layer of voxels lies where the weight fades behind the wall: there it grows with each step.
  const std::unique_ptr<Mapper> mapper = NewMapper();
  for (int i = 0; i < 80; ++i) mapper->Integrate(mapper->head().Next(), WallFrame(445));
  const auto at_445_mm = mapper->Commit().snapshot;
  mapper->Integrate(mapper->head().Next(), WallFrame(448));
  const auto at_448_mm = mapper->Commit().snapshot;
  EXPECT_LT(CountChangedVoxels(*at_445_mm, *at_448_mm), CountMap(*at_448_mm).voxels / 8);
  mapper->Integrate(mapper->head().Next(), WallFrame(465));
  EXPECT_GT(CountChangedVoxels(*at_448_mm, *mapper->Commit().snapshot), 100U);
}

TEST(Mapper, FusesNothingOfDynamicClasses) {
  Frame frame = CircleFrames(1)[0];
  frame.labels = Image<std::uint16_t>(frame.camera.width_px, frame.camera.height_px, 13);
  const std::unique_ptr<Mapper> mapper = NewMapper();
  mapper->Integrate(MapSequence(1), frame);
  EXPECT_TRUE(mapper->Commit().delta.leaves.empty());
}

TEST(Mapper, KeepsColourWhereItWasSeen) {
  Frame frame = CircleFrames(1)[0];
  frame.color = Image<Rgb>(frame.camera.width_px, frame.camera.height_px, Rgb{200, 40, 90});
  const std::unique_ptr<Mapper> mapper = NewMapper();
  for (int i = 0; i < 3; ++i) mapper->Integrate(mapper->head().Next(), frame);
  const MapCommit commit = mapper->Commit();
  const Mesh mesh = ExtractMesh(commit.snapshot->background, commit.snapshot->scale, nullptr);
  ASSERT_EQ(mesh.colors.size(), mesh.vertices_world.size());
  for (const Rgb& color : mesh.colors) ASSERT_EQ(color, (Rgb{200, 40, 90}));
}

TEST(Mapper, TakesFramesOfAnySizeAndDepth) {
  const std::unique_ptr<Mapper> mapper = NewMapper();
  for (const auto& [width_px, height_px] : {std::pair{1, 1}, {2, 1}, {1, 300}, {2, 2}, {37, 5}}) {
    for (const int units : {0, 1, 1000, 65534, 65535}) {
      Frame frame;
      frame.camera = {width_px, height_px, 30.0, 30.0, 0.0, 0.0};
      frame.depth.units =
          Image<std::uint16_t>(width_px, height_px, static_cast<std::uint16_t>(units));
      mapper->Integrate(mapper->head().Next(), frame);
    }
  }
  EXPECT_EQ(mapper->Commit().snapshot->revision, Revision(25));
}

TEST(MapDelta, ApplyUndoesDiff) {
  const std::vector<MapCommit> commits = Map(CircleFrames(10), 5);
  const MapSnapshot& before = *commits[0].snapshot;
  const MapSnapshot& after = *commits[1].snapshot;
  const MapDelta delta = Diff(before, after);
  EXPECT_EQ(delta, commits[1].delta) << "a commit's delta is the difference of its snapshots";
  MapSnapshot applied = before;
  ASSERT_TRUE(Apply(delta, &applied).ok());
  EXPECT_EQ(Vdb(applied), Vdb(after));
  EXPECT_TRUE(Diff(before, before).leaves.empty());
}

TEST(MapDelta, MergeDoesWhatBothDo) {
  const std::vector<MapCommit> commits = Map(CircleFrames(12), 4);
  const MapDelta& a = commits[0].delta;
  const MapDelta& b = commits[1].delta;
  const MapDelta& c = commits[2].delta;
  EXPECT_EQ(Merge(Merge(a, b), c), Merge(a, Merge(b, c)));
  MapSnapshot merged(commits[0].snapshot->scale);
  ASSERT_TRUE(Apply(Merge(Merge(a, b), c), &merged).ok());
  EXPECT_EQ(Vdb(merged), Vdb(*commits[2].snapshot));
}

TEST(MapDelta, MayBeAppliedTwiceButNotOutOfOrder) {
  const std::vector<MapCommit> commits = Map(CircleFrames(9), 3);
  MapSnapshot map(commits[0].snapshot->scale);
  EXPECT_EQ(Apply(commits[1].delta, &map).code(), absl::StatusCode::kFailedPrecondition);
  ASSERT_TRUE(Apply(commits[0].delta, &map).ok());
  ASSERT_TRUE(Apply(commits[1].delta, &map).ok());
  ASSERT_TRUE(Apply(commits[1].delta, &map).ok());
  EXPECT_EQ(Vdb(map), Vdb(*commits[1].snapshot));
  EXPECT_EQ(Apply(commits[0].delta, &map).code(), absl::StatusCode::kFailedPrecondition);
}

TEST(MapDelta, RemovesLeavesThatAreGone) {
  const MapSnapshot full = *Map(CircleFrames(3), 3)[0].snapshot;
  MapSnapshot empty(full.scale);
  empty.revision = full.revision.Next();
  const MapDelta delta = Diff(full, empty);
  EXPECT_EQ(delta.leaves.size(), full.background.leaf_count());
  MapSnapshot map = full;
  ASSERT_TRUE(Apply(delta, &map).ok());
  EXPECT_EQ(map.background.leaf_count(), 0U);
}

TEST(WriteVdb, KeepsToTheBoxAndIsReproducible) {
  const MapSnapshot map = *Map(CircleFrames(3), 3)[0].snapshot;
  EXPECT_EQ(Vdb(map), Vdb(map));
  const Box box(Eigen::Vector3d(0.0, 0.0, 0.0), Eigen::Vector3d(0.5, 0.5, 0.5));
  const std::string part = WriteVdb(map, &box).value();
  EXPECT_LT(part.size(), Vdb(map).size());
}

class RestingMapper : public ::testing::TestWithParam<UpdatePolicy> {
 protected:
  static std::vector<MapDelta> Map(const std::vector<Frame>& frames, std::size_t rest_after) {
    MapConfig config;
    config.policy = GetParam();
    const std::unique_ptr<Mapper> mapper = Mapper::Create(config).value();
    std::vector<MapDelta> deltas;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      if (i % rest_after == rest_after - 1) mapper->ReleaseFrameMemory();
      mapper->Integrate(mapper->head().Next(), frames[i]);
      deltas.push_back(mapper->Commit().delta);
    }
    return deltas;
  }
};

TEST_P(RestingMapper, GoesOnAsIfItHadNotRested) {
  std::vector<Frame> frames = testing::Drive(testing::Room(), 0, 10);
  for (Frame& frame : testing::Drive(testing::RoomWithout(2), 10, 10, 60.0)) {
    frames.push_back(std::move(frame));
  }
  const std::vector<MapDelta> busy = Map(frames, frames.size() + 1);
  EXPECT_EQ(Map(frames, 1), busy);
  EXPECT_EQ(Map(frames, 7), busy);
}

INSTANTIATE_TEST_SUITE_P(Policies, RestingMapper, ::testing::ValuesIn(testing::kAllPolicies));

}  // namespace
}  // namespace steadymap
