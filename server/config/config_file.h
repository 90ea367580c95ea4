#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "server/config/server_config.h"

namespace steadymap {

/// Reads a configuration from TOML `text`; what it does not mention keeps its default. Ranges are
/// not checked: see `ValidateServerConfig`.
/// Errors: `InvalidArgument` with a line `source:LINE:COLUMN: ...` for each syntax error, unknown
/// key and value of the wrong type.
absl::StatusOr<ServerConfig> ParseConfig(std::string_view text, const std::string& source);

/// `ParseConfig` of a file. Errors also: `NotFound` or `PermissionDenied` if it cannot be read.
absl::StatusOr<ServerConfig> LoadConfigFile(const std::filesystem::path& file);

/// The configuration as TOML with a comment at every field; `ParseConfig` gives it back.
std::string PrintConfig(const ServerConfig& config);

}  // namespace steadymap
