#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <absl/status/statusor.h>

#include "server/config/server_config.h"

namespace steadymap {

/// Exit codes of steadymapd, besides 0.
inline constexpr int kExitFailure = 1;     ///< The daemon could not serve, or a check found damage.
inline constexpr int kExitCannotRun = 2;   ///< A store tool could not do its work.
inline constexpr int kExitBadConfig = 78;  ///< Wrong arguments or configuration (EX_CONFIG).

/// The command that steadymapd runs.
enum class Command {
  kServe,
  kCheck,    ///< Search for damage in a store that no server uses.
  kSalvage,  ///< Repair one map of a store that no server uses.
};

/// The parsed command line of steadymapd.
struct CommandLine {
  std::string config_file;              ///< Empty: no file, all defaults.
  std::optional<std::string> listen;    ///< Overrides `listen` of the file.
  std::optional<std::string> data_dir;  ///< Overrides `data_dir` of the file.
  std::string port_file;                ///< File for the port number; empty: none is written.
  bool print_config = false;

  Command command = Command::kServe;
  std::string map;  ///< For `check` and `salvage`: `TENANT/MAP` or a full name.
  std::optional<std::uint64_t> skip_entry;  ///< Option of `salvage`: sequence of an entry.
  std::string output;  ///< Option of `salvage`: output folder; empty: in place.

  /// Set if no command is to be run: after `--help`, `--version` or an error that has already been
  /// printed. The value is the exit code.
  std::optional<int> exit_code;
};

/// Parses the arguments. Prints help and version to stdout, an error as one line to stderr.
CommandLine ParseCommandLine(int argument_count, const char* const* arguments);

/// Returns the requested configuration: the file, overridden by flags. Does not validate it.
/// Errors: those of `LoadConfigFile`.
absl::StatusOr<ServerConfig> ReadConfig(const CommandLine& command_line);

}  // namespace steadymap
