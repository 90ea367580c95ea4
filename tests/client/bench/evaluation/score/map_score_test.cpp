#include "client/bench/evaluation/score/map_score.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "client/bench/evaluation/score/belief_score.h"

namespace steadymap {
namespace {

constexpr double kVoxelM = 0.2;

// Returns a wall of `voxels` x `voxels` voxels, perpendicular to x at `x_m`, from y = z = -0.1
// upwards.
std::vector<SurfacePoint> Wall(double x_m, int voxels, double y_offset_m = 0.0) {
  std::vector<SurfacePoint> points;
  for (int i = 0; i < voxels * 8; ++i) {
    for (int j = 0; j < voxels * 8; ++j) {
      const Eigen::Vector3d position(x_m, y_offset_m - 0.0875 + i * 0.025, -0.0875 + j * 0.025);
      points.push_back({position.cast<float>(), -Eigen::Vector3f::UnitX()});
    }
  }
  return points;
}

// Returns the space observed by a camera at (-2, 0.4, 0.4) facing +x without any surface: a pyramid
// 5 m long.
ObservedSpace WideSpace() {
  ObservedSpace space(kVoxelM, 5.0);
  DepthView view;
  view.camera = {64, 64, 32.0, 32.0, 31.5, 31.5};
  view.depth_m = Image<float>(64, 64, 100.0F);
  view.T_world_camera.linear().col(0) = -Eigen::Vector3d::UnitY();
  view.T_world_camera.linear().col(1) = -Eigen::Vector3d::UnitZ();
  view.T_world_camera.linear().col(2) = Eigen::Vector3d::UnitX();
  view.T_world_camera.translation() = Eigen::Vector3d(-2.0, 0.4, 0.4);
  space.AddView(view);
  return space;
}

// A wall of 5 x 5 voxels at the centres of the voxels at x = 1.
Reference WallReference() {
  Reference reference{.observed = WideSpace()};
  reference.seen = Wall(1.0, 5);
  return reference;
}

TEST(MapScorer, APerfectMapHasNoFault) {
  const MapScore score = MapScorer(WallReference()).Score(Wall(1.0, 5));
  for (const SurfaceScore& row : {score.voxel, score.near}) {
    EXPECT_EQ(row.true_positives, 25U);
    EXPECT_EQ(row.recalled, 25U);
    EXPECT_EQ(row.precision(), 1.0);
    EXPECT_EQ(row.recall(), 1.0);
    EXPECT_EQ(row.false_positive_rate(), 0.0);
    EXPECT_GT(row.true_negatives, 1000U);
  }
}

TEST(MapScorer, AnEmptyMapMissesAllAndHasNoPrecision) {
  const MapScore score = MapScorer(WallReference()).Score({});
  EXPECT_TRUE(std::isnan(score.near.precision()));
  EXPECT_EQ(score.near.recall(), 0.0);
  EXPECT_EQ(score.voxel.missed, 25U);
  EXPECT_EQ(score.voxel.false_positive_rate(), 0.0);
}

// 4 cm across the voxels' border: different voxels, but less than half a voxel apart.
TEST(MapScorer, AShiftAcrossABorderIsPunishedInTheRowVoxelOnly) {
  Reference reference = WallReference();
  reference.seen = Wall(1.08, 5);
  const MapScore score = MapScorer(std::move(reference)).Score(Wall(1.12, 5));
  EXPECT_EQ(score.voxel.precision(), 0.0);
  EXPECT_EQ(score.voxel.recall(), 0.0);
  EXPECT_EQ(score.near.precision(), 1.0);
  EXPECT_EQ(score.near.recall(), 1.0);
}

TEST(MapScorer, AShiftOfMoreThanHalfAVoxelIsWrongAndMissed) {
  const MapScore score = MapScorer(WallReference()).Score(Wall(1.15, 5));
  EXPECT_EQ(score.near.false_positives, 25U);
  EXPECT_EQ(score.near.missed, 25U);
}

TEST(MapScorer, HalfAMapHasHalfTheRecall) {
  std::vector<SurfacePoint> map = Wall(1.0, 5);
  std::erase_if(map, [](const SurfacePoint& point) { return point.position_world.z() > 0.3F; });
  const MapScore score = MapScorer(WallReference()).Score(map);
  EXPECT_EQ(score.voxel.recalled, 10U);
  EXPECT_EQ(score.voxel.missed, 15U);
  EXPECT_EQ(score.voxel.precision(), 1.0);
}

TEST(MapScorer, WhatWasNotObservedDoesNotCount) {
  std::vector<SurfacePoint> map = Wall(1.0, 5);
  const std::vector<SurfacePoint> elsewhere = Wall(-4.0, 5);
  map.insert(map.end(), elsewhere.begin(), elsewhere.end());
  EXPECT_EQ(MapScorer(WallReference()).Score(map).voxel.precision(), 1.0);
}

TEST(MapScorer, TrueSurfaceThatNobodySawIsNeitherWrongNorMissed) {
  Reference reference = WallReference();
  reference.unseen = Wall(0.4, 2);
  const MapScorer scorer(std::move(reference));
  const MapScore without = scorer.Score(Wall(1.0, 5));
  std::vector<SurfacePoint> map = Wall(1.0, 5);
  const std::vector<SurfacePoint> back = Wall(0.4, 2);
  map.insert(map.end(), back.begin(), back.end());
  const MapScore with = scorer.Score(map);
  EXPECT_EQ(without.voxel.missed, 0U);
  EXPECT_EQ(without.near.missed, 0U);
  EXPECT_EQ(with.voxel.false_positives, 0U);
  EXPECT_EQ(with.near.false_positives, 0U);
}

TEST(MapScorer, CountsTheTrailOfWhatMovedThrough) {
  Reference reference = WallReference();
  reference.swept = Wall(0.4, 4);
  const MapScorer scorer(std::move(reference));
  EXPECT_EQ(scorer.Score(Wall(1.0, 5)).trail.value(), 0.0);
  EXPECT_EQ(scorer.Score(Wall(0.45, 2)).trail.part, 9U) << "2 x 2 voxels and their neighbours";
  EXPECT_TRUE(std::isnan(MapScorer(WallReference()).Score(Wall(1.0, 5)).trail.value()));
}

TEST(MapScorer, WhatThingsMovedOnIsNoTrail) {
  Reference reference = WallReference();
  reference.swept = Wall(1.05, 4);
  const MapScorer scorer(std::move(reference));
  const MapScore score = scorer.Score(Wall(1.0, 5));
  EXPECT_EQ(score.trail.whole, 16U);
  EXPECT_EQ(score.trail.part, 0U);
}

TEST(MapScorer, CountsGhostsThatAreStillThere) {
  Reference reference = WallReference();
  reference.vanished = Wall(0.4, 4);
  const MapScorer scorer(std::move(reference));
  EXPECT_EQ(scorer.Score(Wall(1.0, 5)).ghosts.value(), 0.0);
  const MapScore score = scorer.Score(Wall(0.4, 2));
  EXPECT_EQ(score.ghosts.whole, 16U);
  // Two by two voxels, and their neighbours within half a voxel.
  EXPECT_EQ(score.ghosts.part, 9U);
  EXPECT_EQ(score.near.false_positives, 4U);
  EXPECT_EQ(scorer.Score(Wall(0.4, 4)).ghosts.value(), 1.0);
}

TEST(MapScorer, CountsWhatIsKept) {
  Reference reference = WallReference();
  reference.unseen = Wall(1.0, 5, 1.4);
  reference.remembered = Wall(1.0, 5, 1.4);
  const MapScorer scorer(std::move(reference));
  EXPECT_EQ(scorer.Score(Wall(1.0, 5)).kept.value(), 0.0);
  EXPECT_EQ(scorer.Score(Wall(1.0, 5, 1.4)).kept.value(), 1.0);
  EXPECT_TRUE(std::isnan(scorer.Score({}).ghosts.value()));
}

TEST(MapScorer, GroundDoesNotCountEvenWhereItIsNoisy) {
  Reference reference = WallReference();
  std::vector<SurfacePoint> noisy;
  for (int i = 0; i < 40; ++i) {
    for (int j = 0; j < 40; ++j) {
      const auto x = static_cast<float>(i) * 0.025F;
      const auto y = static_cast<float>(j) * 0.025F;
      reference.ground.push_back({{x, y, -0.4F}, Eigen::Vector3f::UnitZ()});
      noisy.push_back({{x, y, -0.29F}, Eigen::Vector3f::UnitZ()});
    }
  }
  std::vector<SurfacePoint> map = Wall(1.0, 5);
  map.insert(map.end(), noisy.begin(), noisy.end());
  const MapScore score = MapScorer(std::move(reference)).Score(map);
  EXPECT_EQ(score.voxel.false_positives, 0U);
  EXPECT_EQ(score.near.false_positives, 0U);
}

TEST(MapScorer, JudgesTheVoxelsThatItCounts) {
  const MapScorer scorer(WallReference());
  std::vector<SurfacePoint> map = Wall(1.0, 3);
  const std::vector<SurfacePoint> ghost = Wall(0.4, 2);
  map.insert(map.end(), ghost.begin(), ghost.end());
  const MapScore score = scorer.Score(map);
  const std::vector<JudgedVoxel> judged = scorer.Judge(map);
  const auto count = [&judged](VoxelVerdict verdict) {
    return static_cast<std::uint64_t>(
        std::count_if(judged.begin(), judged.end(), [verdict](const JudgedVoxel& voxel) {
          return voxel.verdict == verdict;
        }));
  };
  EXPECT_EQ(count(VoxelVerdict::kMatched), score.near.true_positives);
  EXPECT_EQ(count(VoxelVerdict::kWrong), score.near.false_positives);
  EXPECT_EQ(count(VoxelVerdict::kMissed), score.near.missed);
}

TEST(MapScorer, AThingIsTrueWhileHalfOfItsSurfaceIs) {
  const MapScorer scorer(WallReference());
  EXPECT_TRUE(scorer.IsStillTrue(Wall(1.05, 3)));
  EXPECT_FALSE(scorer.IsStillTrue(Wall(1.15, 3)));
  EXPECT_TRUE(scorer.IsStillTrue(Wall(1.0, 6)));
  EXPECT_FALSE(scorer.IsStillTrue(Wall(1.0, 8)));
  EXPECT_FALSE(scorer.IsStillTrue({}));
}

TEST(BrierScore, IsTheMeanSquaredError) {
  const std::vector<BeliefSample> samples = {{1.0, true}, {0.5, false}, {0.2, true}};
  EXPECT_NEAR(BrierScore(samples), (0.0 + 0.25 + 0.64) / 3.0, 1e-12);
  EXPECT_TRUE(std::isnan(BrierScore({})));
}

}  // namespace
}  // namespace steadymap
