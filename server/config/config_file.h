#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "server/config/server_config.h"

namespace steadymap {

/// Parses a configuration from TOML `text`. Fields that the text omits keep their defaults. Does
/// not check ranges: see `ValidateServerConfig`.
/// Errors: `InvalidArgument` with a line `source:LINE:COLUMN: ...` for each syntax error, unknown
/// key and value of the wrong type.
absl::StatusOr<ServerConfig> ParseConfig(std::string_view text, const std::string& source);

/// Reads `file` and parses it with `ParseConfig`.
/// Errors: those of `ParseConfig`; `NotFound` or `PermissionDenied` if the file cannot be read.
absl::StatusOr<ServerConfig> LoadConfigFile(const std::filesystem::path& file);

/// Returns the configuration as TOML with a comment before each field. `ParseConfig` of the result
/// returns an equal configuration.
std::string PrintConfig(const ServerConfig& config);

}  // namespace steadymap
