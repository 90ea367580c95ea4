#include "core/types/policy_parameters.h"

#include <algorithm>
#include <cassert>

#include <absl/strings/str_cat.h>

#include "core/types/absl_text.h"
#include "core/types/pocd_parameters.h"

namespace steadymap {
namespace {

constexpr PolicyParameter kMinStationarity = {
    "min_stationarity",
    0.4,
    0.0,
    0.99,
    false,
    "E[v] below which an object leaves the map (theta_stat)"};

constexpr PolicyParameter kPocdPaper[] = {
    {"association_distance_m",
     0.9,
     0.01,
     10.0,
     false,
     "largest distance of the centres of an object and its observation (theta_dist)"},
    {"max_dissimilarity",
     0.1,
     0.0,
     1.0,
     false,
     "largest share of outliers of an observation after registration (theta_sim)"},
    {"position_weight", 1.0, 0.0, 1e6, false, "cost of a metre of displacement (lambda_1)"},
    {"orientation_weight", 1.0, 0.0, 1e6, false, "cost of a radian of rotation (lambda_2)"},
    {"class_weight", 1000.0, 0.0, 1e6, false, "cost of another class (lambda_3)"},
    {"cost_cutoff", 3.6, 0.0, 1e6, false, "largest cost of an association (theta_cutoff)"},
    {"change_scale", 1.6, 0.1, 10.0, false, "factor on the measured change (lambda_diff)"},
    {"icp_pair_distance_m",
     0.3,
     0.001,
     10.0,
     false,
     "largest distance of two points that the registration pairs"},
    {"icp_outlier_distance_m",
     0.1,
     0.001,
     10.0,
     false,
     "distance from the object from which a registered point is an outlier"},
    {"plane_distance_m",
     0.05,
     0.001,
     1.0,
     false,
     "largest distance of a point from the plane whose class it gets"},
    {"min_plane_samples", 500.0, 10.0, 1e6, true, "least number of samples of a plane"},
    {"cluster_distance_m",
     0.1,
     0.01,
     10.0,
     false,
     "largest distance of two neighbours in a cluster of one class"},
    {"min_cluster_samples", 20.0, 1.0, 1e6, true, "least number of samples of an observation"},
    {"min_merged_overlap",
     0.5,
     0.01,
     1.0,
     false,
     "shared part of the smaller of two cuboids from which observations merge"},
    {"min_visible_share",
     0.2,
     0.0,
     1.0,
     false,
     "share of an object's points in view from which it is expected (theta_vis)"},
    kInitialStationarity,
    kMinStationarity,
    kMaxStationarity,
    kChangeNoise,
    kMaxChange,
    kStationarityWeight,
};

constexpr PolicyParameter kVoxelChange[] = {
    {"frames_per_comparison", 5.0, 1.0, 1000.0, true, "frames between two comparisons"},
    {"visit_gap_s", 30.0, 0.1, 1e6, false, "time without frames that ends a visit"},
    {"comparison_depth_m", 5.0, 0.1, 100.0, false, "depth up to which space is compared"},
};

constexpr PolicyParameter kSubmapChange[] = {
    {"keeping_views", 5.0, 1.0, 1000.0, true, "detections after which a submap is kept"},
    {"misses", 5.0, 1.0, 1000.0, true, "frames without detection that make a submap inactive"},
    {"frames_per_test", 5.0, 1.0, 1000.0, true, "frames between two tests of inactive submaps"},
    {"max_conflict_points",
     20.0,
     0.0,
     1e6,
     false,
     "largest number of contradicted points of a present submap"},
    {"max_conflict_share",
     0.02,
     0.0,
     1.0,
     false,
     "largest share of contradicted points of a present submap"},
    {"min_match_points",
     20.0,
     0.0,
     1e6,
     false,
     "least number of points that agree in two matching submaps"},
    {"min_match_share",
     0.8,
     0.0,
     1.0,
     false,
     "least share of points that agree in two matching submaps"},
    {"match_distance_voxels", 1.0, 0.1, 10.0, false, "distance up to which points agree"},
    {"full_weight", 0.5, 0.001, 100.0, false, "weight from which evidence counts fully"},
    {"comparison_depth_m", 5.0, 0.1, 100.0, false, "depth up to which submaps are tested"},
};

constexpr PolicyParameter kTracking[] = {
    {"max_jump_m", 0.2, 0.001, 10.0, false, "largest motion of an object between two frames"},
    {"max_residual_voxels",
     3.0,
     0.1,
     100.0,
     false,
     "median distance from its surface beyond which an object is lost"},
    {"min_samples", 12.0, 1.0, 1e6, true, "least number of samples that register an object"},
    {"confirming_views", 4.0, 1.0, 1000.0, true, "frames that confirm a new object"},
    {"tentative_age_s",
     10.0,
     0.1,
     1e6,
     false,
     "time without frames after which an unconfirmed object is deleted"},
    {"reported_move_m", 0.1, 0.001, 100.0, false, "distance after which a move is reported"},
};

}  // namespace

std::span<const PolicyParameter> ParametersOf(UpdatePolicy policy) {
  switch (policy) {
    case UpdatePolicy::kStatic:
      return {};
    case UpdatePolicy::kVoxelChange:
      return kVoxelChange;
    case UpdatePolicy::kSubmapChange:
      return kSubmapChange;
    case UpdatePolicy::kTracking:
      return kTracking;
    case UpdatePolicy::kPocd:
      return PocdParameters();
    case UpdatePolicy::kPocdPaper:
      return kPocdPaper;
  }
  return {};
}

const PolicyParameter* FindParameter(UpdatePolicy policy, std::string_view name) {
  const std::span<const PolicyParameter> all = ParametersOf(policy);
  const auto found = std::find_if(all.begin(), all.end(), [name](const PolicyParameter& parameter) {
    return parameter.name == name;
  });
  return found == all.end() ? nullptr : &*found;
}

double ParameterValue(const MapConfig& config, std::string_view name) {
  if (const auto set = config.parameters.find(name); set != config.parameters.end()) {
    return set->second;
  }
  const PolicyParameter* parameter = FindParameter(config.policy, name);
  assert(parameter != nullptr);
  return parameter->default_value;
}

std::string ParameterNames(UpdatePolicy policy) {
  std::string names;
  for (const PolicyParameter& parameter : ParametersOf(policy)) {
    absl::StrAppend(&names, names.empty() ? "" : ", ", Absl(parameter.name));
  }
  return names.empty() ? "none" : names;
}

}  // namespace steadymap
