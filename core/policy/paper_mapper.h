#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "core/association/clusters.h"
#include "core/change/change_estimate.h"
#include "core/frame/frame.h"
#include "core/map/stationarity.h"
#include "core/policy/map_updater.h"
#include "core/policy/segment_fusion.h"
#include "core/registration/icp.h"
#include "core/types/map_config.h"

namespace steadymap {

/// The paper's parameters for TorWIC (Qian et al., RSS 2022).
struct PaperParameters {
  /// Every observation can become an object.
  SegmentFusionParameters segments{.overlap = {}, .max_depth_m = 3.0, .min_new_area_m2 = 0.0};
  ClusterParameters clusters;
  IcpParameters icp;
  /// No cap on what a belief gathers.
  StationarityParameters stationarity{.max_evidence = 1e9};
  /// Centres of an object and its observation lie no further apart, metres (theta_dist).
  double association_distance_m = 0.9;
  /// Largest share of outliers (theta_sim).
  double max_dissimilarity = 0.10;
  /// Weights of the cost: metre, radian, another class (lambda_1, lambda_2, lambda_3).
  double position_weight = 1.0;
  double orientation_weight = 1.0;
  double class_weight = 1000.0;
  /// Dearer pairs are not matched (theta_cutoff).
  double cost_cutoff = 3.6;
  /// An unmatched object is unobserved if this share of its points lies in the frustum (theta_vis).
  double min_visible_share = 0.20;
  /// The geometric change. Distances are truncated as in the volumes.
  ChangeParameters change;
  /// E[v] of a new object, and the one below which an object leaves the map (theta_stat).
  double initial_stationarity = 0.67;
  double min_stationarity = 0.40;
};

/// POCD as published (Qian et al., RSS 2022), the `pocd_paper` policy, for comparison. The
/// observations of a frame (`FindClusters`) are registered by ICP to the objects whose centres are
/// near, and matched one to one at the least cost. A matched observation updates the belief by its
/// geometric change, and is fused if the change is at most tau / 2, else discarded. An object in
/// the frustum that is not matched has the largest change, occluded or not. Other observations are
/// new objects, which are believed at once.
class PaperMapper final : public MapUpdater {
 public:
  PaperMapper(const MapConfig& config, const PaperParameters& parameters);

  void Process(const Frame& frame, SemanticCloud* cloud, WorkingMap* map) override;

 private:
  void Associate();
  void UpdateMatched(std::size_t place, const SemanticCloud& cloud);
  std::optional<double> MeasureChange(std::size_t place, const SemanticCloud& cloud) const;
  bool IsExpectedInView(const TrackedObject& object, const SemanticCloud& cloud) const;
  void CountView(std::size_t samples, TrackedObject* object);
  void Update(TrackedObject* object, double change_m);
  void AddObjects();

  MapConfig config_;
  PaperParameters parameters_;
  SegmentFusion segments_;

  // The frame at hand.
  WorkingMap* map_ = nullptr;
  std::vector<Eigen::Vector3d> shift_of_;  ///< By place in view: of the match onto the object.
};

}  // namespace steadymap
