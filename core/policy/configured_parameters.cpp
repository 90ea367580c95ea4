#include "core/policy/configured_parameters.h"

#include <cstdint>

#include "core/types/policy_parameters.h"

namespace steadymap {
namespace {

std::uint64_t CountOf(const MapConfig& config, std::string_view name) {
  return static_cast<std::uint64_t>(ParameterValue(config, name));
}

/// Sets in `parameters` what the policies `pocd` and `pocd_paper` have in common.
void ReadStationarity(const MapConfig& config, StationarityParameters* parameters) {
  parameters->change_noise_m = ParameterValue(config, "change_noise_m");
  parameters->max_change_m = ParameterValue(config, "max_change_m");
  parameters->class_weight = ParameterValue(config, "stationarity_weight");
  parameters->max_stationarity = ParameterValue(config, "max_stationarity");
}

}  // namespace

VoxelChangeParameters VoxelChangeParametersOf(const MapConfig& config) {
  VoxelChangeParameters parameters;
  parameters.frames_per_comparison = CountOf(config, "frames_per_comparison");
  parameters.visit_gap_s = ParameterValue(config, "visit_gap_s");
  parameters.max_depth_m = ParameterValue(config, "comparison_depth_m");
  return parameters;
}

SubmapChangeParameters SubmapChangeParametersOf(const MapConfig& config) {
  SubmapChangeParameters parameters;
  parameters.keeping_views = CountOf(config, "keeping_views");
  parameters.misses = CountOf(config, "misses");
  parameters.frames_per_test = CountOf(config, "frames_per_test");
  parameters.max_conflict_points = ParameterValue(config, "max_conflict_points");
  parameters.max_conflict_share = ParameterValue(config, "max_conflict_share");
  parameters.min_match_points = ParameterValue(config, "min_match_points");
  parameters.min_match_share = ParameterValue(config, "min_match_share");
  parameters.match_distance_voxels = ParameterValue(config, "match_distance_voxels");
  parameters.full_weight = ParameterValue(config, "full_weight");
  parameters.max_depth_m = ParameterValue(config, "comparison_depth_m");
  return parameters;
}

TrackingParameters TrackingParametersOf(const MapConfig& config) {
  TrackingParameters parameters;
  parameters.max_jump_m = ParameterValue(config, "max_jump_m");
  parameters.registration.search_distance_m = parameters.max_jump_m;
  parameters.max_residual_voxels = ParameterValue(config, "max_residual_voxels");
  parameters.min_samples = CountOf(config, "min_samples");
  parameters.confirming_views = CountOf(config, "confirming_views");
  parameters.tentative_age_s = ParameterValue(config, "tentative_age_s");
  parameters.reported_move_m = ParameterValue(config, "reported_move_m");
  return parameters;
}

PaperParameters PaperParametersOf(const MapConfig& config) {
  PaperParameters parameters;
  parameters.segments.max_depth_m = config.max_depth_m;
  parameters.clusters.plane_distance_m = ParameterValue(config, "plane_distance_m");
  parameters.clusters.min_plane_samples = CountOf(config, "min_plane_samples");
  parameters.clusters.cluster_distance_m = ParameterValue(config, "cluster_distance_m");
  parameters.clusters.min_cluster_samples = CountOf(config, "min_cluster_samples");
  parameters.clusters.min_merged_overlap = ParameterValue(config, "min_merged_overlap");
  parameters.icp.max_pair_distance_m = ParameterValue(config, "icp_pair_distance_m");
  parameters.icp.outlier_distance_m = ParameterValue(config, "icp_outlier_distance_m");
  parameters.change.change_scale = ParameterValue(config, "change_scale");
  parameters.change.truncation_m = config.truncation_m;
  parameters.association_distance_m = ParameterValue(config, "association_distance_m");
  parameters.max_dissimilarity = ParameterValue(config, "max_dissimilarity");
  parameters.position_weight = ParameterValue(config, "position_weight");
  parameters.orientation_weight = ParameterValue(config, "orientation_weight");
  parameters.class_weight = ParameterValue(config, "class_weight");
  parameters.cost_cutoff = ParameterValue(config, "cost_cutoff");
  parameters.min_visible_share = ParameterValue(config, "min_visible_share");
  parameters.initial_stationarity = ParameterValue(config, "initial_stationarity");
  parameters.min_stationarity = ParameterValue(config, "min_stationarity");
  ReadStationarity(config, &parameters.stationarity);
  return parameters;
}

EvidenceMapperParameters EvidenceParametersOf(const MapConfig& config) {
  EvidenceMapperParameters parameters;
  parameters.sessions.max_pause_s = ParameterValue(config, "max_pause_s");
  parameters.sessions.max_duration_s = ParameterValue(config, "max_session_s");
  parameters.poses.sigma_m = ParameterValue(config, "pose_error_m");
  parameters.poses.sigma_rad = ParameterValue(config, "pose_error_rad");
  parameters.poses.correlation_s = ParameterValue(config, "pose_error_time_s");
  SessionIdentityParameters& identity = parameters.identity;
  identity.initial_stationarity = ParameterValue(config, "initial_stationarity");
  ReadStationarity(config, &identity.belief);
  identity.max_pause_s = parameters.sessions.max_pause_s;
  identity.contradiction_window_s = ParameterValue(config, "contradiction_window_s");
  identity.belief.max_evidence = ParameterValue(config, "max_evidence");
  return parameters;
}

}  // namespace steadymap
