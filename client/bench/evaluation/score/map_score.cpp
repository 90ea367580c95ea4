#include "client/bench/evaluation/score/map_score.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include <absl/strings/str_format.h>

#include "client/bench/evaluation/truth/point_index.h"

namespace steadymap {
namespace {

using VoxelPoints = std::unordered_map<VoxelIndex, std::vector<Eigen::Vector3f>>;
using VoxelSet = std::unordered_set<VoxelIndex>;

// Largest distance between surfaces of map and truth in the row `near`, in voxels.
constexpr double kNearVoxels = 0.5;

// Largest error of the mapped ground's height, from noise and drift at a few metres' distance.
constexpr double kGroundNoiseM = 0.12;

// Surface near the ground with at least this upward cosine is mapped ground.
constexpr float kMinGroundCosine = 0.7F;

double Ratio(std::uint64_t part, std::uint64_t whole) {
  if (whole == 0) return std::numeric_limits<double>::quiet_NaN();
  return static_cast<double>(part) / static_cast<double>(whole);
}

VoxelPoints SortIntoVoxels(const std::vector<SurfacePoint>& points, double voxel_size_m) {
  VoxelPoints voxels;
  for (const SurfacePoint& point : points) {
    voxels[VoxelAt(point.position_world, voxel_size_m)].push_back(point.position_world);
  }
  return voxels;
}

VoxelSet VoxelsOf(const std::vector<SurfacePoint>& points, double voxel_size_m) {
  VoxelSet voxels;
  for (const SurfacePoint& point : points) {
    voxels.insert(VoxelAt(point.position_world, voxel_size_m));
  }
  return voxels;
}

PointIndex IndexOf(const std::vector<SurfacePoint>& points, double voxel_size_m) {
  PointIndex index(kNearVoxels * voxel_size_m);
  index.Add(points);
  return index;
}

bool AnyNear(const std::vector<Eigen::Vector3f>& points, const PointIndex& index) {
  return std::any_of(points.begin(), points.end(), [&index](const Eigen::Vector3f& point) {
    return index.HasNear(point);
  });
}

// Returns the points of a voxel, or null.
const std::vector<Eigen::Vector3f>* FindPoints(const VoxelPoints& voxels, const VoxelIndex& voxel) {
  const auto found = voxels.find(voxel);
  return found == voxels.end() ? nullptr : &found->second;
}

Share ShareNear(const VoxelPoints& voxels, const VoxelSet& ground, const PointIndex& map) {
  Share share;
  for (const auto& [voxel, points] : voxels) {
    if (ground.contains(voxel)) continue;
    ++share.whole;
    if (AnyNear(points, map)) ++share.part;
  }
  return share;
}

}  // namespace

double Share::value() const { return Ratio(part, whole); }

Share& Share::operator+=(const Share& other) {
  part += other.part;
  whole += other.whole;
  return *this;
}

std::string CountText(const Share& share) {
  if (share.whole == 0) return "-";
  return absl::StrFormat("%d of %d", share.part, share.whole);
}

double SurfaceScore::precision() const {
  return Ratio(true_positives, true_positives + false_positives);
}

double SurfaceScore::recall() const { return Ratio(recalled, recalled + missed); }

double SurfaceScore::false_positive_rate() const {
  return Ratio(false_positives, false_positives + true_negatives);
}

SurfaceScore& SurfaceScore::operator+=(const SurfaceScore& other) {
  true_positives += other.true_positives;
  false_positives += other.false_positives;
  recalled += other.recalled;
  missed += other.missed;
  true_negatives += other.true_negatives;
  return *this;
}

MapScore& MapScore::operator+=(const MapScore& other) {
  voxel += other.voxel;
  near += other.near;
  ghosts += other.ghosts;
  kept += other.kept;
  trail += other.trail;
  return *this;
}

struct MapScorer::State {
  explicit State(Reference reference)
      : voxel_size_m(reference.observed.voxel_size_m()),
        observed(std::move(reference.observed)),
        seen(SortIntoVoxels(reference.seen, voxel_size_m)),
        unseen(VoxelsOf(reference.unseen, voxel_size_m)),
        ground(VoxelsOf(reference.ground, voxel_size_m)),
        vanished(SortIntoVoxels(reference.vanished, voxel_size_m)),
        remembered(SortIntoVoxels(reference.remembered, voxel_size_m)),
        swept(SortIntoVoxels(reference.swept, voxel_size_m)),
        truth(IndexOf(reference.seen, voxel_size_m)),
        ground_points(kGroundNoiseM) {
    truth.Add(reference.unseen);
    truth.Add(reference.ground);
    ground_points.Add(reference.ground);
  }

  // Returns the surface of a map without the ground.
  std::vector<SurfacePoint> WithoutGround(std::vector<SurfacePoint> map) const {
    std::erase_if(map, [this](const SurfacePoint& point) {
      return point.normal_world.z() > kMinGroundCosine &&
             ground_points.HasNear(point.position_world);
    });
    return map;
  }

  // Returns the surface of a map that is not true.
  std::vector<SurfacePoint> WithoutTruth(std::vector<SurfacePoint> map) const {
    std::erase_if(
        map, [this](const SurfacePoint& point) { return truth.HasNear(point.position_world); });
    return map;
  }

  // Calls `judge(voxel, points of the map, points of the truth, whether unseen truth exists)` for
  // every scored voxel.
  template <typename Function>
  void ForEachCounted(const VoxelPoints& map, Function judge) const {
    observed.ForEach([&](const VoxelIndex& voxel) {
      if (ground.contains(voxel)) return;
      judge(voxel, FindPoints(map, voxel), FindPoints(seen, voxel), unseen.contains(voxel));
    });
  }

  double voxel_size_m;
  ObservedSpace observed;
  VoxelPoints seen;
  VoxelSet unseen;
  VoxelSet ground;
  VoxelPoints vanished;
  VoxelPoints remembered;
  VoxelPoints swept;
  PointIndex truth;  // All true surface, seen or not.
  PointIndex ground_points;
};

MapScorer::MapScorer(Reference reference) : state_(std::make_unique<State>(std::move(reference))) {}

MapScorer::~MapScorer() = default;
MapScorer::MapScorer(MapScorer&&) noexcept = default;

bool MapScorer::IsStillTrue(const std::vector<SurfacePoint>& surface) const {
  const auto count =
      std::count_if(surface.begin(), surface.end(), [this](const SurfacePoint& point) {
        return state_->truth.HasNear(point.position_world);
      });
  return count > 0 && 2 * static_cast<std::size_t>(count) >= surface.size();
}

double MapScorer::voxel_size_m() const { return state_->voxel_size_m; }

std::size_t MapScorer::scored_voxels() const {
  std::size_t count = 0;
  state_->observed.ForEach(
      [&](const VoxelIndex& voxel) { count += state_->ground.contains(voxel) ? 0U : 1U; });
  return count;
}

MapScore MapScorer::Score(const std::vector<SurfacePoint>& map) const {
  using Points = std::vector<Eigen::Vector3f>;
  const std::vector<SurfacePoint> scored = state_->WithoutGround(map);
  const VoxelPoints map_voxels = SortIntoVoxels(scored, state_->voxel_size_m);
  const PointIndex map_index = IndexOf(scored, state_->voxel_size_m);
  MapScore score;
  state_->ForEachCounted(
      map_voxels,
      [&](const VoxelIndex&, const Points* mapped, const Points* seen, bool has_unseen) {
        if (mapped != nullptr) {
          ++(AnyNear(*mapped, state_->truth) ? score.near.true_positives
                                             : score.near.false_positives);
        }
        if (seen != nullptr) {
          ++(AnyNear(*seen, map_index) ? score.near.recalled : score.near.missed);
        }
        if (seen == nullptr && has_unseen) return;
        if (mapped != nullptr)
          ++(seen != nullptr ? score.voxel.true_positives : score.voxel.false_positives);
        if (seen != nullptr) ++(mapped != nullptr ? score.voxel.recalled : score.voxel.missed);
        if (mapped == nullptr && seen == nullptr) {
          ++score.voxel.true_negatives;
          ++score.near.true_negatives;
        }
      });
  score.ghosts = ShareNear(state_->vanished, state_->ground, map_index);
  score.kept = ShareNear(state_->remembered, state_->ground, map_index);
  score.trail = ShareNear(
      state_->swept, state_->ground, IndexOf(state_->WithoutTruth(scored), voxel_size_m()));
  return score;
}

std::vector<JudgedVoxel> MapScorer::Judge(const std::vector<SurfacePoint>& map) const {
  using Points = std::vector<Eigen::Vector3f>;
  const std::vector<SurfacePoint> scored = state_->WithoutGround(map);
  const VoxelPoints map_voxels = SortIntoVoxels(scored, state_->voxel_size_m);
  const PointIndex map_index = IndexOf(scored, state_->voxel_size_m);
  std::vector<JudgedVoxel> judged;
  state_->ForEachCounted(
      map_voxels, [&](const VoxelIndex& voxel, const Points* mapped, const Points* seen, bool) {
        if (mapped != nullptr) {
          const bool is_true = AnyNear(*mapped, state_->truth);
          judged.push_back({voxel, is_true ? VoxelVerdict::kMatched : VoxelVerdict::kWrong});
        } else if (seen != nullptr && !AnyNear(*seen, map_index)) {
          judged.push_back({voxel, VoxelVerdict::kMissed});
        }
      });
  return judged;
}

}  // namespace steadymap
