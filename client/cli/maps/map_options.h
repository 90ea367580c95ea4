#pragma once

#include <optional>
#include <string>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "core/types/map_config.h"

#include "steadymap/v1/map.pb.h"

namespace CLI {
class App;
}

namespace steadymap {

/// The command-line options for the configuration of a new map. An option that is not given has the
/// default of `MapConfig`.
struct MapOptions {
  std::optional<std::string> preset;   ///< One of `PresetNames()`: defaults of what follows.
  std::optional<std::string> policy;   ///< A word of `WordsOf(v1::UpdatePolicy_descriptor())`.
  std::optional<double> voxel_size_m;  ///< Edge of a voxel, metres.
  /// Metres. Default: three voxels.
  std::optional<double> truncation_m;
  std::optional<double> max_depth_m;        ///< Metres.
  std::optional<std::string> classes_file;  ///< A file for `LoadClassTable`.
  std::vector<std::string> parameters;      ///< `NAME=VALUE` for parameters of the policy.

  friend bool operator==(const MapOptions&, const MapOptions&) = default;
};

/// Returns the names of the presets: voxel size, maximum depth and parameters for a kind of place.
std::vector<std::string> PresetNames();

/// Adds the options that set `options`, which must outlive the command.
void AddMapOptions(CLI::App* command, MapOptions* options);

/// Returns a description of these options for the footer of a command, with a list of the policies'
/// parameters.
std::string MapOptionsHelp();

/// Returns the configuration described by the options. Errors: `InvalidArgument` for an unknown
/// policy, a parameter that is not `NAME=VALUE` and for an invalid configuration; as
/// `LoadClassTable`.
absl::StatusOr<MapConfig> ConfigOf(const MapOptions& options);

/// Checks that an existing map agrees with every given option. `wanted` is `ConfigOf` of the
/// options. Errors: `FailedPrecondition` with the first differing option in the message.
absl::Status CheckExistingMap(const MapOptions& options,
                              const MapConfig& wanted,
                              const v1::Map& present);

}  // namespace steadymap
