#include "core/policy/configured_parameters.h"

#include <set>
#include <string>

#include <gtest/gtest.h>

#include "core/policy/map_updater.h"
#include "core/types/policy_parameters.h"
#include "tests/core/policy/map_story.h"

namespace steadymap {
namespace {

using ::steadymap::testing::ConfigOf;

constexpr UpdatePolicy kPolicies[] = {UpdatePolicy::kStatic,
                                      UpdatePolicy::kVoxelChange,
                                      UpdatePolicy::kSubmapChange,
                                      UpdatePolicy::kTracking,
                                      UpdatePolicy::kPocd,
                                      UpdatePolicy::kPocdPaper};

TEST(PolicyParameters, HaveUniqueNamesAndDefaultsWithinTheirRange) {
  for (const UpdatePolicy policy : kPolicies) {
    std::set<std::string_view> names;
    for (const PolicyParameter& parameter : ParametersOf(policy)) {
      EXPECT_TRUE(names.insert(parameter.name).second) << parameter.name;
      EXPECT_LE(parameter.min, parameter.default_value) << parameter.name;
      EXPECT_GE(parameter.max, parameter.default_value) << parameter.name;
      EXPECT_EQ(ParameterValue(ConfigOf(policy), parameter.name), parameter.default_value);
      EXPECT_NE(ParameterNames(policy).find(parameter.name), std::string::npos);
    }
  }
  EXPECT_EQ(ParameterNames(UpdatePolicy::kStatic), "none");
  EXPECT_EQ(FindParameter(UpdatePolicy::kTracking, "cost_cutoff"), nullptr);
}

// A configuration without parameters must give the parameters that the policies document.
TEST(ConfiguredParameters, DefaultsAreThoseOfThePolicies) {
  const PaperParameters paper = PaperParametersOf(ConfigOf(UpdatePolicy::kPocdPaper));
  EXPECT_EQ(paper.stationarity, PaperParameters().stationarity);
  EXPECT_EQ(paper.association_distance_m, PaperParameters().association_distance_m);
  EXPECT_EQ(paper.max_dissimilarity, PaperParameters().max_dissimilarity);
  EXPECT_EQ(paper.position_weight, PaperParameters().position_weight);
  EXPECT_EQ(paper.orientation_weight, PaperParameters().orientation_weight);
  EXPECT_EQ(paper.class_weight, PaperParameters().class_weight);
  EXPECT_EQ(paper.cost_cutoff, PaperParameters().cost_cutoff);
  EXPECT_EQ(paper.min_visible_share, PaperParameters().min_visible_share);
  EXPECT_EQ(paper.initial_stationarity, PaperParameters().initial_stationarity);
  EXPECT_EQ(paper.min_stationarity, PaperParameters().min_stationarity);
  EXPECT_EQ(paper.clusters, PaperParameters().clusters);
  EXPECT_EQ(paper.icp, PaperParameters().icp);
  EXPECT_EQ(paper.change, PaperParameters().change);

  const TrackingParameters tracking = TrackingParametersOf(ConfigOf(UpdatePolicy::kTracking));
  EXPECT_EQ(tracking.registration, TrackingParameters().registration);
  EXPECT_EQ(tracking.max_jump_m, TrackingParameters().max_jump_m);
  EXPECT_EQ(tracking.max_residual_voxels, TrackingParameters().max_residual_voxels);
  EXPECT_EQ(tracking.min_samples, TrackingParameters().min_samples);
  EXPECT_EQ(tracking.confirming_views, TrackingParameters().confirming_views);
  EXPECT_EQ(tracking.tentative_age_s, TrackingParameters().tentative_age_s);
  EXPECT_EQ(tracking.reported_move_m, TrackingParameters().reported_move_m);

  const VoxelChangeParameters voxels =
      VoxelChangeParametersOf(ConfigOf(UpdatePolicy::kVoxelChange));
  EXPECT_EQ(voxels.frames_per_comparison, VoxelChangeParameters().frames_per_comparison);
  EXPECT_EQ(voxels.visit_gap_s, VoxelChangeParameters().visit_gap_s);
  EXPECT_EQ(voxels.max_depth_m, VoxelChangeParameters().max_depth_m);

  const SubmapChangeParameters submaps =
      SubmapChangeParametersOf(ConfigOf(UpdatePolicy::kSubmapChange));
  EXPECT_EQ(submaps.keeping_views, SubmapChangeParameters().keeping_views);
  EXPECT_EQ(submaps.misses, SubmapChangeParameters().misses);
  EXPECT_EQ(submaps.frames_per_test, SubmapChangeParameters().frames_per_test);
  EXPECT_EQ(submaps.max_conflict_points, SubmapChangeParameters().max_conflict_points);
  EXPECT_EQ(submaps.max_conflict_share, SubmapChangeParameters().max_conflict_share);
  EXPECT_EQ(submaps.min_match_points, SubmapChangeParameters().min_match_points);
  EXPECT_EQ(submaps.min_match_share, SubmapChangeParameters().min_match_share);
  EXPECT_EQ(submaps.match_distance_voxels, SubmapChangeParameters().match_distance_voxels);
  EXPECT_EQ(submaps.full_weight, SubmapChangeParameters().full_weight);
  EXPECT_EQ(submaps.max_depth_m, SubmapChangeParameters().max_depth_m);

  EXPECT_EQ(EvidenceParametersOf(ConfigOf(UpdatePolicy::kPocd)), EvidenceMapperParameters());
}

TEST(ConfiguredParameters, EachParameterOfPocdHasAnEffect) {
  const MapConfig defaults = ConfigOf(UpdatePolicy::kPocd);
  for (const PolicyParameter& parameter : ParametersOf(UpdatePolicy::kPocd)) {
    MapConfig config = defaults;
    const double other = parameter.default_value == parameter.max ? parameter.min : parameter.max;
    config.parameters = {{std::string(parameter.name), other}};
    EXPECT_NE(EvidenceParametersOf(config), EvidenceParametersOf(defaults)) << parameter.name;
  }
}

// Otherwise a parameter would be accepted and have no effect.
TEST(ConfiguredParameters, EachParameterChangesThoseOfItsPolicy) {
  MapConfig config = ConfigOf(UpdatePolicy::kPocdPaper);
  config.parameters = {{"change_noise_m", 0.03}, {"max_change_m", 0.6}, {"cost_cutoff", 2.0}};
  const PaperParameters paper = PaperParametersOf(config);
  EXPECT_EQ(paper.stationarity.change_noise_m, 0.03);
  EXPECT_EQ(paper.stationarity.max_change_m, 0.6);
  EXPECT_EQ(paper.cost_cutoff, 2.0);
  config.parameters = {{"plane_distance_m", 0.01},
                       {"min_plane_samples", 100.0},
                       {"cluster_distance_m", 0.02},
                       {"min_cluster_samples", 7.0},
                       {"min_merged_overlap", 0.9}};
  EXPECT_EQ(PaperParametersOf(config).clusters, (ClusterParameters{0.01, 100, 0.02, 7, 0.9}));
  config.parameters = {
      {"icp_pair_distance_m", 0.1}, {"icp_outlier_distance_m", 0.04}, {"change_scale", 1.8}};
  config.truncation_m = 0.06;
  config.max_depth_m = 4.0;
  EXPECT_EQ(PaperParametersOf(config).icp.max_pair_distance_m, 0.1);
  EXPECT_EQ(PaperParametersOf(config).icp.outlier_distance_m, 0.04);
  EXPECT_EQ(PaperParametersOf(config).change, (ChangeParameters{1.8, 0.06}));
  EXPECT_EQ(PaperParametersOf(config).segments.max_depth_m, 4.0);
  config.policy = UpdatePolicy::kTracking;
  config.parameters = {{"max_jump_m", 0.5}, {"min_samples", 30.0}};
  EXPECT_EQ(TrackingParametersOf(config).registration.search_distance_m, 0.5);
  EXPECT_EQ(TrackingParametersOf(config).min_samples, 30U);
  config.policy = UpdatePolicy::kPocd;
  config.parameters = {
      {"initial_stationarity", 0.45}, {"max_evidence", 30.0}, {"max_session_s", 20.0}};
  EXPECT_EQ(EvidenceParametersOf(config).identity.initial_stationarity, 0.45);
  EXPECT_EQ(EvidenceParametersOf(config).identity.belief.max_evidence, 30.0);
  EXPECT_EQ(EvidenceParametersOf(config).sessions.max_duration_s, 20.0);
}

}  // namespace
}  // namespace steadymap
