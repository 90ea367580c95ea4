#include "client/cli/command_line.h"

#include <algorithm>
#include <exception>

#include <CLI/CLI.hpp>

#include "client/cli/bench/evaluate_command.h"
#include "client/cli/bench/evaluate_composite_command.h"
#include "client/cli/bench/evaluate_fleet_command.h"
#include "client/cli/bench/evaluate_rooms_command.h"
#include "client/cli/bench/simulate_command.h"
#include "client/cli/maps/map_commands.h"
#include "client/cli/query/events_command.h"
#include "client/cli/query/export_command.h"
#include "client/cli/query/objects_command.h"
#include "client/cli/query/query_command.h"
#include "client/cli/query/render_command.h"
#include "client/cli/query/robots_command.h"
#include "client/cli/text/error_line.h"
#include "client/cli/upload/upload_command.h"
#include "client/cli/watch/mirror_command.h"
#include "client/cli/watch/watch_command.h"

namespace steadymap {
namespace {

constexpr int kFailed = 1;
constexpr int kMisused = 2;

constexpr char kCommandLineFooter[] =
    "Maps use metres in a right-handed frame with z up. The NAME of a map is its id in the\n"
    "tenant `default`, or tenants/T/maps/M. `steadymap COMMAND --help` describes each command.\n"
    "Results are written to standard output, all other messages to standard error. The exit\n"
    "code is 0 only on success.\n\n"
    "  steadymapd --data-dir /var/lib/steadymap &\n"
    "  steadymap map create kitchen --policy static --voxel-size 0.02\n"
    "  steadymap upload kitchen --format seven-scenes ~/data/7scenes-kitchen\n"
    "  steadymap export kitchen --format ply --output kitchen.ply";

// User input may contain control characters, but an error must be one line.
std::string OnOneLine(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7F; }, ' ');
  return text;
}

void WriteError(const std::string& line, CommandContext* context) {
  context->err << "steadymap: " << OnOneLine(line) << '\n';
}

absl::Status RunAction(const CommandContext& context) {
  try {
    return context.action();
  } catch (const std::exception& error) {
    return absl::InternalError(error.what());
  }
}

// Returns CLI11's message, with the unknown word and a reference to the help text added.
std::string MisuseLine(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App* command = &app;
  std::string path = app.get_name();
  while (!command->get_subcommands().empty()) {
    command = command->get_subcommands().front();
    path += " " + command->get_name();
  }
  std::string line = error.what();
  const std::vector<std::string> unknown = app.remaining(true);
  if (dynamic_cast<const CLI::RequiredError*>(&error) != nullptr && !unknown.empty()) {
    line = "there is no command \"" + unknown.front() + "\"";
  }
  return line + "; see " + path + " --help";
}

std::string CheckServer(const std::string& server) {
  const bool has_port = server.find(':') != std::string::npos && server.back() != ':';
  return has_port ? std::string() : "expected HOST:PORT, got \"" + server + "\"";
}

}  // namespace

int RunCommandLine(const std::vector<std::string>& arguments, CommandContext* context) {
  CLI::App app("Uploads frames to a steadymap server and reads its maps.", "steadymap");
  app.footer(kCommandLineFooter);
  app.require_subcommand(1);
  app.fallthrough();
  app.set_version_flag("--version", STEADYMAP_VERSION);
  app.add_option("--server", context->server, "Address of the server")
      ->type_name("HOST:PORT")
      ->check(CheckServer)
      ->capture_default_str();
  const MapCommands map(&app, context);
  const UploadCommand upload(&app, context);
  const SimulateCommand simulate(&app, context);
  const ObjectsCommand objects(&app, context);
  const EventsCommand events(&app, context);
  const RobotsCommand robots(&app, context);
  const WatchCommand watch(&app, context);
  const MirrorCommand mirror(&app, context);
  const ExportCommand exporting(&app, context);
  const QueryCommand query(&app, context);
  const RenderCommand render(&app, context);
  const EvaluateCommand evaluate(&app, context);
  const EvaluateRoomsCommand evaluate_rooms(&app, context);
  const EvaluateFleetCommand evaluate_fleet(&app, context);
  const EvaluateCompositeCommand evaluate_composite(&app, context);

  try {
    app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error, context->out, context->err);
    WriteError(MisuseLine(app, error), context);
    return kMisused;
  }
  const absl::Status status = RunAction(*context);
  if (status.ok()) return 0;
  WriteError(ErrorLine(status, context->server), context);
  return kFailed;
}

}  // namespace steadymap
