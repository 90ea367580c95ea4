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

// Truncations that the server takes, in voxels, and the one it takes when it has the choice.
constexpr double kMinTruncationVoxels = 2.0;
constexpr double kMaxTruncationVoxels = 16.0;
constexpr double kUsualTruncationVoxels = 3.0;

// The default truncation where the voxel size allows it.
double DefaultTruncation(const MapConfig& config) {
  const double voxels = config.truncation_m / config.voxel_size_m;
  if (voxels >= kMinTruncationVoxels && voxels <= kMaxTruncationVoxels) return config.truncation_m;
  return kUsualTruncationVoxels * config.voxel_size_m;
}

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
                                                    "; leave the option out, or take another map"));
}

}  // namespace

const char kMapOptionsHelp[] =
    "How a map is built is fixed when it is created, so that its frames always lead to the same "
    "map.\n"
    "--policy static fuses every frame and forgets nothing; pocd keeps objects, and notices what "
    "was\n"
    "moved or removed: it needs labels, or instances, of each frame. The others are there to "
    "compare\n"
    "with. The truncation's default is 0.15 m, or three voxels where 0.15 m is not 2 to 16 of "
    "them.\n"
    "--classes names a text file with a line `ID NAME [static|semi-static|dynamic|background]` a "
    "class;\n"
    "pixels of dynamic classes are never mapped. A name of several words needs the word behind "
    "it.\n"
    "Without --classes the map has the TorWIC classes.";

void AddMapOptions(CLI::App* command, MapOptions* options) {
  const MapConfig defaults;
  command->add_option(
      "--policy",
      options->policy,
      "How the map decides what to believe: " + WordsOf(v1::UpdatePolicy_descriptor()));
  command->add_option("--voxel-size", options->voxel_size_m, "Edge of a voxel, metres, 0.001 to 1")
      ->default_str(absl::StrCat(defaults.voxel_size_m));
  command
      ->add_option("--truncation",
                   options->truncation_m,
                   "Distances are kept within this of a surface, metres, 2 to 16 voxels")
      ->default_str(absl::StrCat(defaults.truncation_m));
  command
      ->add_option(
          "--max-depth", options->max_depth_m, "Depth beyond this is not used, metres, 0.1 to 100")
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
  config.truncation_m = options.truncation_m ? *options.truncation_m : DefaultTruncation(config);
  if (options.max_depth_m) config.max_depth_m = *options.max_depth_m;
  if (options.classes_file) {
    absl::StatusOr<std::vector<SemanticClass>> classes = LoadClassTable(*options.classes_file);
    if (!classes.ok()) return classes.status();
    config.classes = *std::move(classes);
  }
  // Here rather than on the server, which takes zeros for "the default".
  if (absl::Status status = ValidateMapConfig(config); !status.ok()) return status;
  return config;
}

absl::Status CheckPresentMap(const MapOptions& options,
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
