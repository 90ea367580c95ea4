#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "client/bench/evaluation/truth/observed_space.h"
#include "client/bench/evaluation/truth/surface_points.h"

/// Accuracy of a map's surface.
namespace steadymap {

/// A counted share.
struct Share {
  std::uint64_t part = 0;
  std::uint64_t whole = 0;

  /// In [0, 1]; NaN if `whole` is 0.
  double value() const;

  Share& operator+=(const Share& other);
};

/// Returns a share as `3 of 4`; `-` if `whole` is 0.
std::string CountText(const Share& share);

/// Voxel counts of map and truth. With a tolerance, one map voxel can match several true voxels, so
/// map and truth are counted separately.
struct SurfaceScore {
  std::uint64_t true_positives = 0;   ///< Map voxels with true surface.
  std::uint64_t false_positives = 0;  ///< Map voxels without true surface.
  std::uint64_t recalled = 0;         ///< True voxels that the map contains.
  std::uint64_t missed = 0;           ///< True voxels that the map lacks.
  std::uint64_t true_negatives = 0;   ///< Neither map nor truth has surface.

  double precision() const;            ///< NaN for an empty map.
  double recall() const;               ///< NaN without true surface.
  double false_positive_rate() const;  ///< false / (false positives + true negatives).

  SurfaceScore& operator+=(const SurfaceScore& other);
};

/// All scores of the surface of one map.
struct MapScore {
  SurfaceScore voxel;  ///< Match: map and truth have surface in the same voxel.
  SurfaceScore near;   ///< Match: surfaces are at most half a voxel apart.
  Share ghosts;        ///< Voxels of removed surface that the map still contains.
  Share kept;          ///< Voxels of surface seen only earlier, in the map.
  /// Voxels visited by moving objects in which the map has untrue surface. The floor under the
  /// objects is true surface and does not count.
  Share trail;

  MapScore& operator+=(const MapScore& other);
};

/// Ground truth of a map score.
struct Reference {
  /// Only these voxels are scored.
  ObservedSpace observed;
  /// True surface visible in the last sequence.
  std::vector<SurfacePoint> seen{};
  /// True surface invisible in the last sequence: voxels without other true surface are not scored.
  std::vector<SurfacePoint> unseen{};
  /// Surface observed by earlier sequences, removed since, and carved free by the last one.
  std::vector<SurfacePoint> vanished{};
  /// True surface observed by earlier sequences only.
  std::vector<SurfacePoint> remembered{};
  /// Surface of moving objects at every observed position.
  std::vector<SurfacePoint> swept{};
  /// Not scored: the voxels of the ground, and map surface that lies within 0.12 m of it and faces
  /// up. The ground is so large that it would dominate the score.
  std::vector<SurfacePoint> ground{};
};

/// Verdict on a voxel of the row `near`.
enum class VoxelVerdict {
  kMatched,  ///< Map surface that is true.
  kWrong,    ///< Map surface that is not true.
  kMissed,   ///< True surface that the map lacks.
};

/// A voxel and its verdict.
struct JudgedVoxel {
  VoxelIndex voxel;
  VoxelVerdict verdict = VoxelVerdict::kMatched;
};

/// Compares maps with one reference. Map surface outside the observed voxels is not scored.
class MapScorer {
 public:
  explicit MapScorer(Reference reference);
  ~MapScorer();
  MapScorer(MapScorer&&) noexcept;

  /// Scores a map's surface, sampled at most a quarter of a voxel apart.
  MapScore Score(const std::vector<SurfacePoint>& map) const;

  /// Returns the verdicts of the row `near`, in no particular order.
  std::vector<JudgedVoxel> Judge(const std::vector<SurfacePoint>& map) const;

  /// True if an object with this surface is in place: at least half of the surface lies within half
  /// a voxel of true surface. False for an empty surface.
  bool IsStillTrue(const std::vector<SurfacePoint>& surface) const;

  double voxel_size_m() const;

  /// Number of scored voxels.
  std::size_t scored_voxels() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace steadymap
