#pragma once

#include <cstddef>
#include <optional>
#include <vector>

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
  SegmentFusionParameters segments{.overlap = {}, .max_depth_m = 3.0};
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
  /// The geometric change: distances are truncated as in the volumes, noise is left in.
  ChangeParameters change{.truncation_m = 0.15, .subtracts_noise = false};
  /// E[v] of a new object, and the one below which an object leaves the map (theta_stat).
  double initial_stationarity = 0.67;
  double min_stationarity = 0.40;
};

/// POCD as its paper has it, without what steadymap adds (Qian et al., RSS 2022):
/// clusters of one label are registered by ICP to the objects whose centres are near and matched
/// one to one at the least cost; an object in the frustum that is not matched is contradicted,
/// occluded or not; new objects are believed at once. The `pocd_paper` policy, to compare with.
class PaperMapper final : public MapUpdater {
 public:
  PaperMapper(const MapConfig& config, const PaperParameters& parameters);

  void Process(const Frame& frame, SemanticCloud* cloud, WorkingMap* map) override;

 private:
  std::vector<std::optional<std::size_t>> Associate();
  std::optional<double> MeasureChange(std::size_t place, const SemanticCloud& cloud) const;
  bool IsExpectedInView(const TrackedObject& object, const SemanticCloud& cloud) const;
  void CountView(std::size_t samples, TrackedObject* object);
  void Update(TrackedObject* object, double change_m);
  void AddObjects();

  MapConfig config_;
  PaperParameters parameters_;
  SegmentFusion segments_;
  WorkingMap* map_ = nullptr;  ///< Of the frame at hand.
};

}  // namespace steadymap
