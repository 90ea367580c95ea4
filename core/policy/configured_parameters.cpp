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

// The parts of the parameters of the policy `pocd`.

/// Returns the number of samples of the smallest square segment.
std::size_t MinSegmentSamples(const MapConfig& config) {
  const double side_samples = ParameterValue(config, "min_segment_width_samples");
  return static_cast<std::size_t>(side_samples * side_samples);
}

SessionLimits SessionLimitsOf(const MapConfig& config) {
  SessionLimits limits;
  limits.max_pause_s = ParameterValue(config, "max_pause_s");
  limits.max_duration_s = ParameterValue(config, "max_session_s");
  return limits;
}

LocalizationMonitorParameters GuardParametersOf(const MapConfig& config) {
  LocalizationMonitorParameters parameters;
  parameters.jump_m = ParameterValue(config, "max_session_offset_m");
  parameters.jump_m_per_s = ParameterValue(config, "max_speed_m_per_s");
  parameters.motion_s = ParameterValue(config, "motion_s");
  parameters.fit_if_right = ParameterValue(config, "fit_of_right_pose");
  parameters.fit_if_wrong = ParameterValue(config, "fit_of_wrong_pose");
  parameters.new_place_odds = ParameterValue(config, "new_place_odds");
  parameters.look_s = ParameterValue(config, "look_interval_s");
  parameters.rearranged_share = ParameterValue(config, "rearranged_share");
  parameters.error_share = ParameterValue(config, "lost_error_share");
  parameters.views.min_normal_cosine = ParameterValue(config, "min_plane_cosine");
  parameters.views.min_facing_cosine = ParameterValue(config, "min_facing_cosine");
  parameters.views.through_m = parameters.jump_m;
  return parameters;
}

PoseFilterParameters PoseFilterParametersOf(const MapConfig& config) {
  PoseFilterParameters parameters;
  parameters.sigma_m = ParameterValue(config, "pose_error_m");
  parameters.sigma_rad = ParameterValue(config, "pose_error_rad");
  parameters.correlation_s = ParameterValue(config, "pose_error_time_s");
  parameters.surface_sigma_voxels = ParameterValue(config, "map_error_voxels");
  parameters.max_sigmas = ParameterValue(config, "max_sigmas");
  parameters.place_sigma_m = ParameterValue(config, "place_error_m");
  parameters.min_normal_cosine = ParameterValue(config, "min_surface_cosine");
  parameters.session_share = ParameterValue(config, "session_surface_weight");
  parameters.look_s = ParameterValue(config, "look_interval_s");
  return parameters;
}

SurfaceShares SharesOf(const MapConfig& config) {
  SurfaceShares shares;
  shares.negligible = ParameterValue(config, "negligible_share");
  shares.substantial = ParameterValue(config, "substantial_share");
  shares.majority = ParameterValue(config, "majority_share");
  return shares;
}

LookParameters LookParametersOf(const MapConfig& config) {
  LookParameters parameters;
  parameters.max_sigmas = ParameterValue(config, "max_sigmas");
  parameters.pose_sigma_m = ParameterValue(config, "frame_error_m");
  parameters.min_facing_cosine = ParameterValue(config, "min_facing_cosine");
  parameters.min_normal_cosine = ParameterValue(config, "min_surface_cosine");
  parameters.min_interval_s = ParameterValue(config, "look_interval_s");
  parameters.confirming_looks = static_cast<int>(CountOf(config, "min_frames"));
  const SurfaceShares shares = SharesOf(config);
  parameters.min_gone_cells = CountOf(config, "min_points");
  parameters.negligible_share = shares.negligible;
  parameters.whole_gone_share = shares.most();
  return parameters;
}

SegmentAssignmentParameters AssignmentParametersOf(const MapConfig& config) {
  SegmentAssignmentParameters parameters;
  parameters.min_new_area_m2 = ParameterValue(config, "min_area_m2");
  parameters.min_width_samples = ParameterValue(config, "min_segment_width_samples");
  parameters.gaps.max_width_m = ParameterValue(config, "max_gap_m");
  parameters.gaps.max_sigmas = ParameterValue(config, "max_sigmas");
  parameters.gaps.min_level_cosine = ParameterValue(config, "min_plane_cosine");
  parameters.gaps.min_lines = CountOf(config, "min_points");
  return parameters;
}

SceneDivisionParameters SceneParametersOf(const MapConfig& config) {
  SceneDivisionParameters parameters;
  parameters.min_plane_area_m2 = ParameterValue(config, "min_plane_area_m2");
  parameters.min_plane_cosine = ParameterValue(config, "min_plane_cosine");
  parameters.min_support_area_m2 = ParameterValue(config, "min_support_area_m2");
  parameters.min_weighted_area_m2 = ParameterValue(config, "min_weighted_area_m2");
  parameters.near_voxels = ParameterValue(config, "near_voxels");
  parameters.min_width_voxels = ParameterValue(config, "min_width_voxels");
  parameters.max_leg_share = ParameterValue(config, "max_leg_share");
  parameters.gaps.min_frames = CountOf(config, "min_frames");
  parameters.gaps.reach_m = ParameterValue(config, "max_gap_m");
  parameters.gaps.min_cosine = ParameterValue(config, "min_plane_cosine");
  return parameters;
}

SessionPartParameters PartParametersOf(const MapConfig& config) {
  SessionPartParameters parameters;
  parameters.min_frames = CountOf(config, "min_frames");
  parameters.min_area_m2 = ParameterValue(config, "min_area_m2");
  parameters.shares = SharesOf(config);
  parameters.min_points = CountOf(config, "min_points");
  parameters.min_doubted_frames = CountOf(config, "min_doubted_frames");
  parameters.surface.contact_voxels = ParameterValue(config, "contact_voxels");
  parameters.surface.min_normal_cosine = ParameterValue(config, "min_match_cosine");
  parameters.surface.max_sigmas = ParameterValue(config, "max_sigmas");
  parameters.surface.place_sigma_m = ParameterValue(config, "place_error_m");
  parameters.surface.surface_sigma_voxels = ParameterValue(config, "surface_error_voxels");
  parameters.fragment_share = ParameterValue(config, "fragment_share");
  parameters.max_hidden_gap_share = ParameterValue(config, "max_hidden_gap_share");
  parameters.max_leg_width_m = ParameterValue(config, "max_leg_width_m");
  parameters.max_leg_gap_m = ParameterValue(config, "max_leg_gap_m");
  parameters.max_gap_m = ParameterValue(config, "max_gap_m");
  parameters.concave_cost_m = ParameterValue(config, "concave_cost_m");
  parameters.behind_m = ParameterValue(config, "open_behind_m");
  parameters.scene = SceneParametersOf(config);
  return parameters;
}

SessionIdentityParameters IdentityParametersOf(const MapConfig& config) {
  SessionIdentityParameters parameters;
  parameters.parts = PartParametersOf(config);
  parameters.initial_stationarity = ParameterValue(config, "initial_stationarity");
  parameters.claim_votes = ParameterValue(config, "claim_votes");
  parameters.max_session_offset_m = ParameterValue(config, "max_session_offset_m");
  parameters.vote_scale_m = ParameterValue(config, "vote_scale_m");
  parameters.max_displacement_m =
      ParameterValue(config, "max_sigmas") * ParameterValue(config, "frame_error_m");
  parameters.max_pose_sigmas = ParameterValue(config, "max_sigmas");
  parameters.min_looked_at_area_m2 = ParameterValue(config, "min_judged_area_m2");
  parameters.min_part_cells = CountOf(config, "min_part_cells");
  parameters.max_pause_s = ParameterValue(config, "max_pause_s");
  parameters.contradiction_window_s = ParameterValue(config, "contradiction_window_s");
  ReadStationarity(config, &parameters.belief);
  parameters.belief.max_evidence = ParameterValue(config, "max_evidence");
  return parameters;
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
  parameters.sessions = SessionLimitsOf(config);
  parameters.guard = GuardParametersOf(config);
  parameters.poses = PoseFilterParametersOf(config);
  parameters.moving.memory_s = ParameterValue(config, "motion_s");
  parameters.continuity.max_sigmas = ParameterValue(config, "max_sigmas");
  parameters.continuity.min_samples = MinSegmentSamples(config);
  parameters.continuity.min_facing_cosine = ParameterValue(config, "min_segment_facing_cosine");
  parameters.looks = LookParametersOf(config);
  parameters.assignment = AssignmentParametersOf(config);
  parameters.identity = IdentityParametersOf(config);
  return parameters;
}

}  // namespace steadymap
