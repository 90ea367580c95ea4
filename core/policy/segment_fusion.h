#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "core/association/association.h"
#include "core/association/observation.h"
#include "core/association/projected_overlap.h"
#include "core/association/sample_grid.h"
#include "core/integration/semantic_cloud.h"
#include "core/integration/tsdf_integrator.h"
#include "core/types/map_config.h"
#include "core/working/tracked_object.h"
#include "core/working/working_map.h"

namespace steadymap {

/// How segments find their objects.
struct SegmentFusionParameters {
  OverlapParameters overlap;
  /// Objects are looked for up to this depth, metres.
  double max_depth_m = 5.0;
  /// Smallest surface that becomes an object, square metres.
  double min_new_area_m2 = 0.06;
};

/// Divides the samples of a frame into segments, and sets the owners of the samples that belong to
/// the background.
using FrameDivision = std::function<std::vector<Observation>(
    const SampleGrid& samples, const Eigen::Vector3d& camera_world, Association* association)>;

/// What the policies share that follow objects in the picture: segments by label, matched with the
/// objects they overlap, fused into them; what matches none becomes an object. One frame at a time,
/// one thread.
class SegmentFusion {
 public:
  /// Segments are connected surfaces of one label (`FindSegments`).
  SegmentFusion(const MapConfig& config, const SegmentFusionParameters& parameters);

  /// Segments are those of `division`.
  SegmentFusion(const MapConfig& config,
                const SegmentFusionParameters& parameters,
                FrameDivision division);

  /// The objects that may be in view, by rising id.
  std::vector<TrackedObject*> Candidates(const SemanticCloud& cloud, WorkingMap* map) const;

  /// Divides the frame into segments, none of them matched, and sees which candidates are in view.
  /// All three must outlive the frame.
  void Part(const std::vector<TrackedObject*>& candidates, SemanticCloud* cloud, WorkingMap* map);

  /// Says for each segment with which object in view it is matched.
  void SetMatches(std::vector<std::optional<std::size_t>> matches);

  /// Divides the frame, and matches the segments with the candidates that they overlap.
  void Match(const std::vector<TrackedObject*>& candidates, SemanticCloud* cloud, WorkingMap* map);

  /// The candidates in view, and after `AddObjects` the new ones behind them.
  const std::vector<ObjectInView>& in_view() const { return in_view_; }

  const std::vector<Observation>& segments() const { return segments_; }

  /// The samples of a segment, world frame, metres.
  std::vector<Eigen::Vector3d> PointsOf(const Observation& segment) const;

  /// Samples of the segments that the object at `place` in view was matched with.
  std::size_t CountSamples(std::size_t place) const;

  /// Those samples, world frame, metres, in the order of the picture.
  std::vector<Eigen::Vector3d> PointsOf(std::size_t place) const;

  /// Takes the segments of the object at `place` away from it. They can become new objects.
  void Release(std::size_t place);

  /// Takes the segments of the object at `place` away from it. Nothing of them is fused.
  void Discard(std::size_t place);

  /// Makes objects of the segments without one, but for small ones, which are not fused.
  void AddObjects();

  /// Fuses each object's segments into it, and the background's part into the background.
  void Fuse();

 private:
  SegmentFusionParameters parameters_;
  FrameDivision division_;
  TsdfIntegrator integrator_;

  // The frame at hand.
  WorkingMap* map_ = nullptr;
  SemanticCloud* cloud_ = nullptr;
  SampleGrid samples_;
  Association association_;
  std::vector<Observation> segments_;
  std::vector<std::optional<std::size_t>> matches_;  ///< By segment: place in view.
  std::vector<std::uint8_t> is_discarded_;           ///< By segment.
  std::vector<ObjectInView> in_view_;
  std::vector<std::vector<std::size_t>> segments_of_;  ///< By place in view, rising.
};

}  // namespace steadymap
