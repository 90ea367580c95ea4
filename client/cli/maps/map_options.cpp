#include "client/cli/maps/map_options.h"

#include <string_view>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <absl/strings/str_cat.h>

#include "client/cli/maps/class_table_file.h"
#include "client/cli/text/enumerator_text.h"
#include "client/cli/text/number_text.h"
#include "core/types/error.h"
#include "proto/convert_map.h"

namespace steadymap {
namespace {

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

const char kMapOptionsHelp[] =
    "These options are fixed when a map is created, so that the same frames always give the\n"
    "same map. --policy static fuses all frames; surface that rays pass through disappears\n"
    "gradually. pocd keeps objects and detects moved and removed ones; it needs labels or\n"
    "instances in each frame. The other policies are baselines for comparison. The default\n"
    "truncation is three voxels. --classes is a text file with one line `ID NAME\n"
    "[static|semi-static|dynamic|background]` for each class. Pixels of dynamic classes are\n"
    "never mapped. A name of several words must be followed by one of these words. Without\n"
    "--classes, the map has the TorWIC classes.";

void AddMapOptions(CLI::App* command, MapOptions* options) {
  const MapConfig defaults;
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
}

absl::StatusOr<MapConfig> ConfigOf(const MapOptions& options) {
  MapConfig config;
  if (options.policy) {
    const absl::StatusOr<UpdatePolicy> policy = PolicyOf(*options.policy);
    if (!policy.ok()) return policy.status();
    config.policy = *policy;
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
    const std::optional<double>& given_m;
    const char* option;
    double found_m;
  };

  for (const Length& length : {Length{options.voxel_size_m, "--voxel-size", found->voxel_size_m},
                               Length{options.truncation_m, "--truncation", found->truncation_m},
                               Length{options.max_depth_m, "--max-depth", found->max_depth_m}}) {
    if (!length.given_m || *length.given_m == length.found_m) continue;
    return Differs(present, length.option, LengthText(length.found_m), LengthText(*length.given_m));
  }
  if (options.classes_file && found->classes != wanted.classes) {
    return Differs(present, "--classes", "other classes", "those of " + *options.classes_file);
  }
  return absl::OkStatus();
}

}  // namespace steadymap
