#include "client/cli/bench/evaluate_fleet_command.h"

#include <algorithm>

#include <CLI/CLI.hpp>

#include "client/bench/evaluation/fleet/fleet_evaluation.h"
#include "client/bench/evaluation/method/method.h"
#include "client/bench/evaluation/route_evaluation.h"
#include "client/bench/simulator/routes/named_routes.h"
#include "client/cli/bench/parameter_option.h"
#include "client/cli/text/argument_text.h"
#include "client/cli/upload/progress_report.h"

namespace steadymap {
namespace {

constexpr char kFleetFooter[] =
    "Plays a simulated route into one map for each case and scores it by the world of the last\n"
    "drive, as `steadymap evaluate` does. F1: strict one-to-one score of created and removed.\n"
    "Created to lost: number of events. Archived: objects that the map keeps but does not show.\n\n"
    "Cases:\n"
    "  one-robot       The route as it is, at 10 Hz with pauses of 60 s.\n"
    "  2hz 5hz 15hz 30hz\n"
    "                  The same drives at other frame rates.\n"
    "  pause-1s pause-60s pause-3d\n"
    "                  Other pauses.\n"
    "  one-upload-1s   All drives in one upload, with pauses of 1 s.\n"
    "  newest-first    The last drive arrives first. The map cannot tell the changes then.\n"
    "  newest-first-2  The same, with the other drives, the first one twice, from a second robot.\n"
    "  two-robots      Every second frame is from a second robot.\n"
    "  two-clocks      The clock of the second robot is 10 minutes ahead.\n"
    "  two-clocks-5cm  Its poses are off by 5 cm, too.\n"
    "  offset-10cm     The poses of the second robot are off by 10 cm.\n"
    "  contradicting   In three further drives, the first robot sees the world as it was in the\n"
    "                  first drive, the second one as it was in the last.";

}  // namespace

EvaluateFleetCommand::EvaluateFleetCommand(CLI::App* app, CommandContext* context)
    : context_(context) {
  CLI::App* const command = app->add_subcommand(
      "evaluate-fleet", "Score maps of several robots, at other rates and with wrong clocks");
  command->footer(kFleetFooter);
  command->add_option("--route", route_, "Simulated route")
      ->check(CLI::IsMember(RouteNames()))
      ->capture_default_str();
  command->add_option("--case", cases_, "Cases to evaluate (default: all)")
      ->check(CLI::IsMember(FleetCaseNames()));
  command->add_option("--policy", policy_, "Update policy of the maps")
      ->check(CLI::IsMember(MethodNames()))
      ->capture_default_str();
  AddParameterOption(command, &parameters_);
  command->add_option("--seed", seed_, "Seed of all noise")->type_name("N")->capture_default_str();
  command->callback([this] { context_->action = [this] { return Run(); }; });
}

absl::Status EvaluateFleetCommand::Run() const {
  const absl::StatusOr<Route> route = MakeRoute(route_);
  if (!route.ok()) return route.status();
  absl::StatusOr<ParameterValues> parameters = ParseParameters(parameters_);
  if (!parameters.ok()) return parameters.status();
  MapConfig base = MapConfigFor(route_);
  base.parameters = *std::move(parameters);
  const absl::StatusOr<std::vector<Method>> methods = SelectMethods({policy_}, base);
  if (!methods.ok()) return methods.status();
  FleetEvaluationOptions options;
  for (const Method& method : *methods) {
    if (method.name == policy_) options.config = method.config;
  }
  for (const FleetCase& fleet_case : FleetCases()) {
    if (cases_.empty() ||
        std::find(cases_.begin(), cases_.end(), fleet_case.name) != cases_.end()) {
      options.cases.push_back(fleet_case);
    }
  }
  options.seed = seed_;
  options.voxel_size_m = EvaluationVoxelFor(route_);
  ProgressReport report(&context_->err,
                        context_->err_is_terminal,
                        "evaluated",
                        options.cases.size(),
                        SteadySeconds,
                        "cases");
  std::size_t done = 0;
  options.on_case = [&report, &done] {
    ++done;
    report.Update(done, done);
  };
  const absl::StatusOr<std::vector<FleetResult>> results = EvaluateFleet(*route, options);
  report.End();
  if (!results.ok()) return results.status();
  context_->out << FleetTable(*results);
  return absl::OkStatus();
}

}  // namespace steadymap
