#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "client/bench/evaluation/truth/observed_space.h"
#include "client/bench/evaluation/truth/surface_points.h"

/// How true a map's surface is (client/README.md#evaluation).
namespace steadymap {

/// A part of a whole, counted.
struct Share {
  std::uint64_t part = 0;
  std::uint64_t whole = 0;

  /// In [0, 1]; NaN where there is no whole.
  double value() const;

  Share& operator+=(const Share& other);
};

/// Voxels by what the map and the truth have in them. Where a tolerance lets one voxel answer for
/// another, as many true voxels may be found as it takes, so map and truth count their own.
struct SurfaceScore {
  std::uint64_t true_positives = 0;   ///< Of the map: its surface is true.
  std::uint64_t false_positives = 0;  ///< Of the map: its surface is not.
  std::uint64_t recalled = 0;         ///< Of the truth: the map has the surface.
  std::uint64_t missed = 0;           ///< Of the truth: the map lacks the surface.
  std::uint64_t true_negatives = 0;   ///< Neither map nor truth has surface.

  double precision() const;            ///< Of the map; NaN for an empty map.
  double recall() const;               ///< Of the truth; NaN where nothing is true.
  double false_positive_rate() const;  ///< false / (false positives + true negatives).

  SurfaceScore& operator+=(const SurfaceScore& other);
};

/// All that is said about the surface of one map.
struct MapScore {
  SurfaceScore voxel;  ///< A voxel of the map is true if there is true surface in that very voxel.
  SurfaceScore near;   ///< A voxel matches if the other side's surface comes within half a voxel.
  Share ghosts;  ///< Of the voxels of vanished surface, those where the map still has surface.
  Share kept;    ///< Of the voxels of surface only remembered, those where the map has surface.
  /// Of the voxels that moving things were seen in, those where it has surface that is not true:
  /// what they stood or rolled on may be there.
  Share trail;

  MapScore& operator+=(const MapScore& other);
};

/// What a map is compared with.
struct Reference {
  /// Other voxels do not count.
  ObservedSpace observed;
  /// True surface that the last run could see.
  std::vector<SurfacePoint> seen{};
  /// True surface that it could not: voxels with no other true surface do not count.
  std::vector<SurfacePoint> unseen{};
  /// Surface that earlier runs saw, that is no more, and that the last run looked through.
  std::vector<SurfacePoint> vanished{};
  /// True surface that only earlier runs saw.
  std::vector<SurfacePoint> remembered{};
  /// Surface of things that move, wherever a run saw it.
  std::vector<SurfacePoint> swept{};
  /// Not scored: the voxels it runs through, and what of a map lies within 0.12 m of it and faces
  /// up. There is so much ground that it would drown what the score is about.
  std::vector<SurfacePoint> ground{};
};

/// What a voxel of the row `near` turned out to be.
enum class VoxelVerdict {
  kMatched,  ///< Surface of the map that is true.
  kWrong,    ///< Surface of the map that is not.
  kMissed,   ///< True surface that the map lacks.
};

/// A voxel and its verdict.
struct JudgedVoxel {
  VoxelIndex voxel;
  VoxelVerdict verdict = VoxelVerdict::kMatched;
};

/// Compares maps with one reference. What a map has outside the observed voxels is neither right
/// nor wrong.
class MapScorer {
 public:
  explicit MapScorer(Reference reference);
  ~MapScorer();
  MapScorer(MapScorer&&) noexcept;

  /// Scores the surface of a map, sampled at most a quarter of a voxel apart.
  MapScore Score(const std::vector<SurfacePoint>& map) const;

  /// The verdicts behind the row `near`, in no particular order.
  std::vector<JudgedVoxel> Judge(const std::vector<SurfacePoint>& map) const;

  /// Whether a thing with this surface stands where the map has it: at least half of the surface
  /// lies within half a voxel of true surface. Nothing is not true.
  bool IsStillTrue(const std::vector<SurfacePoint>& surface) const;

  double voxel_size_m() const;

  /// Observed voxels that count.
  std::size_t scored_voxels() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace steadymap
