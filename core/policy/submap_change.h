#pragma once

#include <cstdint>
#include <vector>

#include "core/change/view_free_space.h"
#include "core/frame/frame.h"
#include "core/policy/map_updater.h"
#include "core/policy/segment_fusion.h"
#include "core/types/map_config.h"

namespace steadymap {

/// How submaps come, are judged and go.
struct SubmapChangeParameters {
  SegmentFusionParameters segments;
  /// Frames that must detect a new submap for it to stay.
  std::uint64_t keeping_views = 5;
  /// Frames in a row without a detection after which a submap is no longer fused into.
  std::uint64_t misses = 5;
  /// Inactive submaps are tested every so many frames, >= 1. Less often costs latency.
  std::uint64_t frames_per_test = 5;
  /// A submap is absent when more than so many of its surface points are contradicted, ...
  double max_conflict_points = 20.0;
  /// ... and more than this share of all of them.
  double max_conflict_share = 0.02;
  /// It matches another one when so many of the points that the other knows agree, at least ...
  double min_match_points = 20.0;
  /// ... this share of them.
  double min_match_share = 0.8;
  /// Points agree up to this distance from the other surface and contradict it beyond, voxels.
  double match_distance_voxels = 1.0;
  /// Evidence of this weight or more counts fully: one look at 1 m, face on, weighs 1.
  double full_weight = 0.5;
  /// Submaps this close to the camera are tested, metres.
  double max_depth_m = 5.0;
};

/// The `submap_change` policy (Schmid et al., Panoptic Multi-TSDFs, ICRA 2022): objects are
/// submaps, found again by their overlap in the picture alone. What was not detected for a few
/// frames is tested against what is seen now, and is in or out of the map as a whole by the last
/// test.
///
/// `ObjectState::views` counts detections, `absences` the misses in a row, up to those that make a
/// submap inactive. The belief means nothing.
class SubmapMapper final : public MapUpdater {
 public:
  SubmapMapper(const MapConfig& config, const SubmapChangeParameters& parameters);

  void Process(const Frame& frame, SemanticCloud* cloud, WorkingMap* map) override;

 private:
  /// How many points of one surface another one, or a frame, confirms and contradicts.
  struct Tally {
    double known = 0.0;
    double matching = 0.0;
    double contradicted = 0.0;
  };

  bool IsActive(const ObjectState& state) const {
    return state.contradicted_updates < parameters_.misses;
  }

  /// Whether a submap was kept and is inactive: one that was forgotten in this frame is not.
  bool IsDormant(const ObjectState& state) const {
    return !IsActive(state) && state.supporting_frames >= parameters_.keeping_views;
  }

  void CountDetections();
  void KeepOrMerge();
  TrackedObject* FindInactiveTwin(const TrackedObject& fresh);
  void Reactivate(TrackedObject* twin, TrackedObject* fresh);
  void TestInactive(const ViewFreeSpace& view);
  void Decide(const Tally& tally, TrackedObject* object);
  bool IsMatch(const Tally& tally) const;
  Tally Compare(const TrackedObject& object, const TrackedObject& other) const;
  double CountLookedThrough(const TrackedObject& object, const ViewFreeSpace& view) const;

  SubmapChangeParameters parameters_;
  SegmentFusion segments_;
  MinDepthGrid tiles_;
  WorkingMap* map_ = nullptr;  ///< Of the frame at hand.
};

}  // namespace steadymap
