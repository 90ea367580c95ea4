#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <absl/status/statusor.h>

#include "server/config/server_config.h"

namespace steadymap {

/// Exit codes of steadymapd, besides 0.
inline constexpr int kExitFailure = 1;     ///< It could not serve; a check has found damage.
inline constexpr int kExitCannotRun = 2;   ///< A tool could not do its work at all.
inline constexpr int kExitBadConfig = 78;  ///< Arguments or configuration: sysexits' EX_CONFIG.

/// What steadymapd is to do.
enum class Command {
  kServe,
  kCheck,    ///< Look for damage in a store that nobody serves.
  kSalvage,  ///< Repair one map of it.
};

/// What steadymapd was asked for on its command line.
struct CommandLine {
  std::string config_file;              ///< Empty: none, all defaults.
  std::optional<std::string> listen;    ///< Overrides the file's.
  std::optional<std::string> data_dir;  ///< Overrides the file's.
  std::string port_file;                ///< Where to write the port; empty: nowhere.
  bool print_config = false;

  Command command = Command::kServe;
  std::string map;                          ///< Of the tools: `TENANT/MAP` or a full name.
  std::optional<std::uint64_t> skip_entry;  ///< Of `salvage`.
  std::string output;                       ///< Of `salvage`: a folder; empty: in place.

  /// Set when there is nothing to run: after `--help`, `--version` or a mistake, which has been
  /// told already. The value is the exit code.
  std::optional<int> exit_code;
};

/// Reads the arguments; help and version go to stdout, mistakes to stderr in one line.
CommandLine ParseCommandLine(int argument_count, const char* const* arguments);

/// The configuration that is asked for: file, then flags, not yet validated.
/// Errors: as `LoadConfigFile`.
absl::StatusOr<ServerConfig> ReadConfig(const CommandLine& command_line);

}  // namespace steadymap
