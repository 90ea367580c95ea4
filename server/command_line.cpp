#include "server/command_line.h"

#include <cstdio>

#include <CLI/CLI.hpp>

#include "server/config_file.h"

namespace steadymap {

CommandLine ParseCommandLine(int argument_count, const char* const* arguments) {
  CommandLine result;
  CLI::App app("steadymapd: keeps object-level maps of places, fed and read over gRPC",
               "steadymapd");
  app.set_version_flag("--version", std::string("steadymapd ") + STEADYMAP_VERSION);
  app.add_option("--config", result.config_file, "Configuration file (TOML); all defaults without")
      ->type_name("FILE");
  app.add_option("--listen", result.listen, "Overrides `listen`; port 0 takes a free one")
      ->type_name("HOST:PORT");
  app.add_option("--data-dir", result.data_dir, "Overrides `data_dir`")->type_name("DIR");
  app.add_option("--port-file", result.port_file, "File to write the port to once it is served")
      ->type_name("FILE");
  app.add_flag("--print-config",
               result.print_config,
               "Print the configuration that is in force, with comments, and end");
  try {
    app.parse(argument_count, arguments);
  } catch (const CLI::Success& success) {
    result.exit_code = app.exit(success);
  } catch (const CLI::ParseError& error) {
    std::fprintf(stderr, "steadymapd: %s (see --help)\n", error.what());
    result.exit_code = 1;
  }
  return result;
}

absl::StatusOr<ServerConfig> ReadConfig(const CommandLine& command_line) {
  ServerConfig config;
  if (!command_line.config_file.empty()) {
    absl::StatusOr<ServerConfig> loaded = LoadConfigFile(command_line.config_file);
    if (!loaded.ok()) return loaded;
    config = *std::move(loaded);
  }
  if (command_line.listen) config.listen = *command_line.listen;
  if (command_line.data_dir) config.data_dir = *command_line.data_dir;
  return config;
}

}  // namespace steadymap
