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
      "check", "Check every file of a store that no server uses, and list the damaged ones");
  check->add_option("--map", result->map, kMapHelp)->type_name("NAME");
  CLI::App* const salvage = app->add_subcommand(
      "salvage", "Repair one map of a store that no server uses; the old files are kept");
  salvage->add_option("--map", result->map, kMapHelp)->type_name("NAME")->required();
  salvage->add_option("--skip-entry", result->skip_entry, "Skip this entry of the log")
      ->type_name("N");
  salvage
      ->add_option(
          "--output", result->output, "Write the repaired map to this folder instead of the store")
      ->type_name("DIR");
}

}  // namespace

CommandLine ParseCommandLine(int argument_count, const char* const* arguments) {
  CommandLine result;
  CLI::App app(
      "steadymapd: stores object-level maps of changing places; upload and query over gRPC",
      "steadymapd");
  app.set_version_flag("--version", std::string("steadymapd ") + STEADYMAP_VERSION);
  app.add_option("--config",
                 result.config_file,
                 "Configuration file (TOML); without it all settings have their defaults")
      ->type_name("FILE");
  app.add_option("--listen", result.listen, "Overrides `listen`; port 0 selects a free port")
      ->type_name("HOST:PORT");
  app.add_option("--data-dir", result.data_dir, "Overrides `data_dir`")->type_name("DIR");
  app.add_option("--port-file",
                 result.port_file,
                 "File to which the port is written when the server is ready")
      ->type_name("FILE");
  app.add_flag("--print-config",
               result.print_config,
               "Print the effective configuration with comments, and exit");
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
