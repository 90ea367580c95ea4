#include "client/cli/maps/map_options.h"

#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_join.h>

#include "client/cli/maps/class_table_file.h"
#include "client/cli/text/argument_text.h"
#include "client/cli/text/enumerator_text.h"
#include "client/cli/text/number_text.h"
#include "core/types/absl_text.h"
#include "core/types/error.h"
#include "core/types/policy_parameters.h"
#include "proto/convert_map.h"

namespace steadymap {
namespace {

/// A value of a policy's parameter. Policies without the parameter ignore it.
struct ParameterSetting {
  const char* name;
  double value;
};

/// The scale of a kind of place.
struct Preset {
  const char* name;
  double voxel_size_m;
  double max_depth_m;
  std::span<const ParameterSetting> settings;
};

// ToyCar (Qian et al., RSS 2022); the last four, which the paper does not state, as the voxels.
constexpr ParameterSetting kTableTop[] = {{"change_noise_m", 0.03},
                                          {"max_change_m", 0.6},
                                          {"min_stationarity", 0.45},
                                          {"change_scale", 1.8},
                                          {"plane_distance_m", 0.02},
                                          {"cluster_distance_m", 0.04},
                                          {"icp_pair_distance_m", 0.12},
                                          {"icp_outlier_distance_m", 0.04}};

// Between a table-top and a warehouse, as the things in it are.
constexpr ParameterSetting kOffice[] = {{"change_noise_m", 0.1},
                                        {"max_change_m", 2.0},
                                        {"plane_distance_m", 0.03},
                                        {"cluster_distance_m", 0.06},
                                        {"icp_pair_distance_m", 0.18},
                                        {"icp_outlier_distance_m", 0.06}};

// Of a warehouse: the defaults, which are those of TorWIC (Qian et al., RSS 2022).
constexpr Preset kPresets[] = {
    {"warehouse", 0.05, 3.0, {}},
    {"office", 0.03, 4.0, kOffice},
    {"table-top", 0.02, 4.0, kTableTop},
};

constexpr char kMapOptionsHelp[] =
    "These options are fixed when a map is created, so that the same frames always give the\n"
    "same map. --policy static fuses all frames; surface that rays pass through disappears\n"
    "gradually. pocd keeps objects and detects moved and removed ones; labels or instances in\n"
    "each frame help it. The other policies are baselines for comparison. The default\n"
    "truncation is three voxels. --classes is a text file with one line `ID NAME\n"
    "[static|semi-static|dynamic|background]` for each class. Pixels of dynamic classes are\n"
    "never mapped. A name of several words must be followed by one of these words. Without\n"
    "--classes, the map has the TorWIC classes. --preset sets voxel size, maximum depth and the\n"
    "parameters of pocd and pocd_paper for a kind of place; other options override it.";

std::string WordOfPolicy(UpdatePolicy policy) {
  return WordOf(v1::UpdatePolicy_descriptor(), ToProto(policy));
}

absl::StatusOr<UpdatePolicy> PolicyOf(const std::string& word) {
  const int policy = NumberOf(v1::UpdatePolicy_descriptor(), word);
  if (policy != 0) return FromProto(static_cast<v1::UpdatePolicy>(policy));
  return InvalidField(reason::kBadValue,
                      "policy",
                      "the policy must be one of " + WordsOf(v1::UpdatePolicy_descriptor()) +
                          ", got \"" + word + "\"");
}

absl::Status ApplyPreset(const std::string& name, MapConfig* config) {
  for (const Preset& preset : kPresets) {
    if (name != preset.name) continue;
    config->voxel_size_m = preset.voxel_size_m;
    config->max_depth_m = preset.max_depth_m;
    for (const ParameterSetting& setting : preset.settings) {
      if (FindParameter(config->policy, setting.name) == nullptr) continue;
      config->parameters[setting.name] = setting.value;
    }
    return absl::OkStatus();
  }
  return InvalidField(
      reason::kBadValue,
      "preset",
      "the preset must be one of " + absl::StrJoin(PresetNames(), ", ") + ", got \"" + name + "\"");
}

absl::Status Differs(const v1::Map& present,
                     const char* option,
                     const std::string& found,
                     const std::string& wanted) {
  return absl::FailedPreconditionError(absl::StrCat(present.name(),
                                                    " exists already and has ",
                                                    option,
                                                    " ",
                                                    found,
                                                    ", not ",
                                                    wanted,
                                                    "; omit the option or use another map"));
}

}  // namespace

std::vector<std::string> PresetNames() {
  std::vector<std::string> names;
  for (const Preset& preset : kPresets) names.emplace_back(preset.name);
  return names;
}

std::string MapOptionsHelp() {
  std::string help = kMapOptionsHelp;
  for (const UpdatePolicy policy : {UpdatePolicy::kPocd,
                                    UpdatePolicy::kPocdPaper,
                                    UpdatePolicy::kVoxelChange,
                                    UpdatePolicy::kSubmapChange,
                                    UpdatePolicy::kTracking}) {
    absl::StrAppend(&help, "\n\nParameters of ", WordOfPolicy(policy), " (--set NAME=VALUE):");
    for (const PolicyParameter& parameter : ParametersOf(policy)) {
      absl::StrAppendFormat(&help,
                            "\n  %-23s %s; %s, %s to %s",
                            Absl(parameter.name),
                            Absl(parameter.description),
                            absl::StrCat(parameter.default_value),
                            absl::StrCat(parameter.min),
                            absl::StrCat(parameter.max));
    }
  }
  return help;
}

void AddMapOptions(CLI::App* command, MapOptions* options) {
  const MapConfig defaults;
  command
      ->add_option(
          "--preset", options->preset, "Scale of the place: " + absl::StrJoin(PresetNames(), ", "))
      ->type_name("NAME");
  command->add_option("--policy",
                      options->policy,
                      "Update policy of the map: " + WordsOf(v1::UpdatePolicy_descriptor()));
  command->add_option("--voxel-size", options->voxel_size_m, "Edge of a voxel, metres, 0.001 to 1")
      ->default_str(absl::StrCat(defaults.voxel_size_m));
  command
      ->add_option("--truncation",
                   options->truncation_m,
                   "Half-width of the truncation band around surfaces, metres, 2 to 16 voxels")
      ->default_str("three voxels");
  command
      ->add_option(
          "--max-depth", options->max_depth_m, "Largest depth that is used, metres, 0.1 to 100")
      ->default_str(absl::StrCat(defaults.max_depth_m));
  command->add_option("--classes", options->classes_file, "File with the map's class table")
      ->type_name("FILE");
  command->add_option("--set", options->parameters, "Parameters of the policy, listed below")
      ->type_name("NAME=VALUE");
}

absl::StatusOr<MapConfig> ConfigOf(const MapOptions& options) {
  MapConfig config;
  if (options.policy) {
    const absl::StatusOr<UpdatePolicy> policy = PolicyOf(*options.policy);
    if (!policy.ok()) return policy.status();
    config.policy = *policy;
  }
  if (options.preset) {
    if (absl::Status status = ApplyPreset(*options.preset, &config); !status.ok()) return status;
  }
  if (options.voxel_size_m) config.voxel_size_m = *options.voxel_size_m;
  config.truncation_m =
      options.truncation_m ? *options.truncation_m : DefaultTruncationM(config.voxel_size_m);
  if (options.max_depth_m) config.max_depth_m = *options.max_depth_m;
  if (options.classes_file) {
    absl::StatusOr<std::vector<SemanticClass>> classes = LoadClassTable(*options.classes_file);
    if (!classes.ok()) return classes.status();
    config.classes = *std::move(classes);
  }
  const absl::StatusOr<ParameterValues> parameters = ParseParameters(options.parameters);
  if (!parameters.ok()) return parameters.status();
  for (const auto& [name, value] : *parameters) config.parameters[name] = value;
  // Validated here, because the server treats a zero as "the default".
  if (absl::Status status = ValidateMapConfig(config); !status.ok()) return status;
  return config;
}

absl::Status CheckExistingMap(const MapOptions& options,
                              const MapConfig& wanted,
                              const v1::Map& present) {
  if (options == MapOptions()) return absl::OkStatus();
  const absl::StatusOr<MapConfig> found = FromProto(present.config());
  if (!found.ok()) return found.status();
  if (options.policy && found->policy != wanted.policy) {
    return Differs(present, "--policy", WordOfPolicy(found->policy), WordOfPolicy(wanted.policy));
  }

  struct Length {
    bool is_given;
    const char* option;
    double found_m;
    double wanted_m;
  };

  const bool has_preset = options.preset.has_value();
  for (const Length& length : {Length{has_preset || options.voxel_size_m,
                                      "--voxel-size",
                                      found->voxel_size_m,
                                      wanted.voxel_size_m},
                               Length{has_preset || options.truncation_m,
                                      "--truncation",
                                      found->truncation_m,
                                      wanted.truncation_m},
                               Length{has_preset || options.max_depth_m,
                                      "--max-depth",
                                      found->max_depth_m,
                                      wanted.max_depth_m}}) {
    if (!length.is_given || length.wanted_m == length.found_m) continue;
    return Differs(present, length.option, LengthText(length.found_m), LengthText(length.wanted_m));
  }
  for (const auto& [name, value] : wanted.parameters) {
    const bool is_known = FindParameter(found->policy, name) != nullptr;
    const double found_value = is_known ? ParameterValue(*found, name) : value;
    if (found_value == value) continue;
    return Differs(present, "--set", absl::StrCat(name, "=", found_value), absl::StrCat(value));
  }
  if (options.classes_file && found->classes != wanted.classes) {
    return Differs(present, "--classes", "other classes", "those of " + *options.classes_file);
  }
  return absl::OkStatus();
}

}  // namespace steadymap
