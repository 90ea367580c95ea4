#include "server/command_line.h"

#include <cstdio>

#include <CLI/CLI.hpp>

#include "server/config/config_file.h"

namespace steadymap {

namespace {

constexpr char kMapHelp[] = "The map: TENANT/MAP, or tenants/TENANT/maps/MAP";

void AddTools(CLI::App* app, CommandLine* result) {
  // Allows --data-dir and --config after the name of the tool.
  app->fallthrough();
  app->require_subcommand(0, 1);
  CLI::App* const check = app->add_subcommand(
      "check", "Read every file of a store that nobody serves, and name what is damaged");
  check->add_option("--map", result->map, kMapHelp)->type_name("NAME");
  CLI::App* const salvage =
      app->add_subcommand("salvage", "Repair one map; its old files are kept beside the store's");
  salvage->add_option("--map", result->map, kMapHelp)->type_name("NAME")->required();
  salvage->add_option("--skip-entry", result->skip_entry, "Give this entry of the log no effect")
      ->type_name("N");
  salvage->add_option("--output", result->output, "Put the repaired map there, not into the store")
      ->type_name("DIR");
}

}  // namespace

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
  AddTools(&app, &result);
  try {
    app.parse(argument_count, arguments);
  } catch (const CLI::Success& success) {
    result.exit_code = app.exit(success);
  } catch (const CLI::ParseError& error) {
    std::fprintf(stderr, "steadymapd: %s (see --help)\n", error.what());
    result.exit_code = kExitBadConfig;
  }
  if (app.got_subcommand("check")) result.command = Command::kCheck;
  if (app.got_subcommand("salvage")) result.command = Command::kSalvage;
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
