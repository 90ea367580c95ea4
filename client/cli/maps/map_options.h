#pragma once

#include <optional>
#include <string>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "core/types/map_config.h"

#include "steadymap/v1/map.pb.h"

namespace CLI {
class App;
}

namespace steadymap {

/// The options of the command line that say how a new map is built. What is not given has the
/// default of `MapConfig`.
struct MapOptions {
  std::optional<std::string> policy;   ///< A word of `WordsOf(v1::UpdatePolicy_descriptor())`.
  std::optional<double> voxel_size_m;  ///< Edge of a voxel, metres.
  std::optional<double> truncation_m;  ///< Metres; else 0.15, or three voxels if that fits better.
  std::optional<double> max_depth_m;   ///< Metres.
  std::optional<std::string> classes_file;  ///< As `LoadClassTable` reads it.

  friend bool operator==(const MapOptions&, const MapOptions&) = default;
};

/// Adds options that change a MapOptions, which must outlive the command.
void AddMapOptions(CLI::App* command, MapOptions* options);

/// What the footer of a command with these options says of them.
extern const char kMapOptionsHelp[];

/// The configuration that the options describe.
/// Errors: `InvalidArgument` for a policy that is unknown and for what no map can have; as
/// `LoadClassTable`.
absl::StatusOr<MapConfig> ConfigOf(const MapOptions& options);

/// OK if a map that is there agrees with every option that was given; `wanted` is `ConfigOf` of the
/// options. Errors: `FailedPrecondition` that names the first option that differs.
absl::Status CheckPresentMap(const MapOptions& options,
                             const MapConfig& wanted,
                             const v1::Map& present);

}  // namespace steadymap
