// Parallel loops: each item is processed once, and the result is bit-identical for any thread
// count.

#include "core/types/parallel.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <mutex>
#include <random>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/map/placed_volume.h"
#include "core/mapper.h"
#include "core/query/map_mesh.h"
#include "tests/core/policy/room_drive.h"
#include "tests/support/all_policies.h"
#include "tests/support/thread_limit.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Drive;
using ::steadymap::testing::Room;
using ::steadymap::testing::RoomWithout;
using ::steadymap::testing::RunOnThreads;

using Range = std::pair<std::size_t, std::size_t>;

std::vector<Range> RangesOf(std::size_t count, std::size_t min_range) {
  std::mutex mutex;
  std::vector<Range> ranges;
  ParallelFor(count, min_range, [&](std::size_t begin, std::size_t end) {
    const std::lock_guard lock(mutex);
    ranges.emplace_back(begin, end);
  });
  std::sort(ranges.begin(), ranges.end());
  return ranges;
}

TEST(ParallelFor, RangesMeetAndNoneIsTooShort) {
  std::mt19937 random(1);
  for (int round = 0; round < 300; ++round) {
    const std::size_t count = random() % 2000;
    const std::size_t min_range = 1 + random() % 300;
    const std::vector<Range> ranges =
        RunOnThreads(1 + round % 8, [&] { return RangesOf(count, min_range); });
    std::size_t next = 0;
    for (const auto& [begin, end] : ranges) {
      ASSERT_EQ(begin, next);
      ASSERT_GE(end - begin, std::min(count, min_range)) << count << " by " << min_range;
      next = end;
    }
    ASSERT_EQ(next, count);
  }
}

TEST(ParallelFor, LittleWorkStaysWithTheCaller) {
  EXPECT_EQ(RunOnThreads(8, [] { return RangesOf(64, 64); }), (std::vector<Range>{{0, 64}}));
  EXPECT_TRUE(RangesOf(0, 1).empty());
  EXPECT_GT(RunOnThreads(8, [] { return RangesOf(64, 8); }).size(), 1U);
}

TEST(ParallelFor, CallsTheHookOnceOnEachHelper) {
  static thread_local int hook_calls = 0;
  SetHelperThreadHook([] { ++hook_calls; });
  std::atomic<int> oftener = 0;
  std::atomic<int> callers = 0;
  const std::thread::id caller = std::this_thread::get_id();
  for (int round = 0; round < 100; ++round) {
    ParallelFor(64, 1, [&](std::size_t, std::size_t) {
      if (hook_calls > 1) ++oftener;
      if (std::this_thread::get_id() == caller && hook_calls > 0) ++callers;
    });
  }
  SetHelperThreadHook(nullptr);
  EXPECT_EQ(oftener, 0);
  EXPECT_EQ(callers, 0);
}

TEST(ParallelFor, ExceptionsComeOut) {
  const auto fail = [] {
    ParallelFor(100, 1, [](std::size_t begin, std::size_t end) {
      if (begin <= 77 && 77 < end) throw std::runtime_error("item 77");
    });
  };
  EXPECT_THROW(RunOnThreads(4, fail), std::runtime_error);
}

TEST(ParallelFor, TakesTheWorkOwnerAlong) {
  int owner = 0;
  SetWorkOwner(&owner);
  std::atomic<int> strangers = 0;
  const auto look = [&strangers, &owner](std::size_t, std::size_t) {
    if (WorkOwner() != &owner) ++strangers;
    ParallelFor(16, 1, [&](std::size_t, std::size_t) {
      if (WorkOwner() != &owner) ++strangers;
    });
  };
  // The same pool threads process work without an owner before and after.
  const auto work = [&] {
    for (int round = 0; round < 50; ++round) {
      ParallelFor(64, 1, look);
      SetWorkOwner(nullptr);
      ParallelFor(64, 1, [&strangers](std::size_t, std::size_t) {
        if (WorkOwner() != nullptr) ++strangers;
      });
      SetWorkOwner(&owner);
    }
  };
  work();
  EXPECT_EQ(WorkOwner(), &owner);
  EXPECT_EQ(strangers, 0);
  SetWorkOwner(nullptr);
}

/// The output of a mapper for a drive through a room that changes during the drive.
struct DriveResult {
  std::vector<MapDelta> deltas;
  Mesh mesh;
};

DriveResult MapDrive(UpdatePolicy policy, const std::vector<Frame>& frames) {
  MapConfig config;
  config.policy = policy;
  config.voxel_size_m = 0.02;
  config.truncation_m = 0.06;
  const std::unique_ptr<Mapper> mapper = Mapper::Create(config).value();
  DriveResult result;
  std::shared_ptr<const MapSnapshot> map;
  for (const Frame& frame : frames) {
    mapper->Integrate(mapper->head().Next(), frame);
    MapCommit commit = mapper->Commit();
    map = std::move(commit.snapshot);
    result.deltas.push_back(std::move(commit.delta));
  }
  result.mesh = ExtractMapMesh(ShownVolumes(*map), map->scale, nullptr);
  return result;
}

class SameBits : public ::testing::TestWithParam<UpdatePolicy> {};

TEST_P(SameBits, ForAnyNumberOfThreads) {
  std::vector<Frame> frames = Drive(Room(), 0, 8);
  for (Frame& frame : Drive(RoomWithout(2), 8, 8, 60.0)) frames.push_back(std::move(frame));
  const DriveResult alone = RunOnThreads(1, [&] { return MapDrive(GetParam(), frames); });
  ASSERT_GT(alone.deltas.front().leaves.size(), 512U) << "too few for several batches and ranges";
  ASSERT_GT(alone.mesh.triangles.size(), 10'000U);
  for (const int threads : {2, 3, 8}) {
    const DriveResult result = RunOnThreads(threads, [&] { return MapDrive(GetParam(), frames); });
    EXPECT_EQ(result.deltas, alone.deltas) << threads << " threads";
    EXPECT_EQ(result.mesh.vertices_world, alone.mesh.vertices_world) << threads << " threads";
    EXPECT_EQ(result.mesh.normals_world, alone.mesh.normals_world);
    EXPECT_EQ(result.mesh.colors, alone.mesh.colors);
    EXPECT_EQ(result.mesh.triangles, alone.mesh.triangles);
  }
}

INSTANTIATE_TEST_SUITE_P(Policies, SameBits, ::testing::ValuesIn(testing::kAllPolicies));

}  // namespace
}  // namespace steadymap
