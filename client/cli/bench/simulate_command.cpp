#include "client/cli/bench/simulate_command.h"

#include <memory>

#include <CLI/CLI.hpp>

#include "client/bench/simulator/routes/named_routes.h"
#include "client/bench/simulator/simulated_frame_source.h"
#include "client/bench/simulator/torwic_writer.h"
#include "client/cli/upload/progress_report.h"

namespace steadymap {
namespace {

std::string SimulateFooter() {
  std::string footer =
      "Simulates a robot on a route through a small warehouse whose boxes and fences have\n"
      "moved between the sequences. The frames of its depth camera are uploaded, or written to\n"
      "a folder in the TorWIC layout. The same route and seed always give the same frames.\n\n"
      "Routes:";
  for (const std::string& route : RouteNames()) footer += " " + route;
  return footer +
         " clutter-SEED\n\n"
         "A map that does not exist is created if --policy is given. The options from --policy\n"
         "to --classes are those of `steadymap map create`, whose --help describes them.";
}

}  // namespace

SimulateCommand::SimulateCommand(CLI::App* app, CommandContext* context) : context_(context) {
  options_.source = simulation_.source;
  CLI::App* const command =
      app->add_subcommand("simulate", "Upload or write the frames of a simulated robot");
  command->footer(SimulateFooter());
  CLI::Option* const name = command->add_option("NAME", options_.map, "The map to upload to");
  command
      ->add_option("--write", directory_, "Write a recording to this folder instead of uploading")
      ->type_name("DIR")
      ->excludes(name);
  command->add_option("--route", route_, "Route of the robot")->required();
  command->add_option("--seed", simulation_.seed, "Seed of all noise")->capture_default_str();
  CLI::Option* const ideal = command->add_flag_callback(
      "--ideal",
      [this] { simulation_.sensor = SensorModel::Ideal(); },
      "Use a sensor without noise, holes or drift");
  command
      ->add_flag_callback(
          "--hard",
          [this] { simulation_.sensor = SensorModel::Hard(); },
          "Use a sensor with correlated noise, fattened foreground, 7 % wrong labels, drift "
          "without bound and an offset of 5 cm between sequences")
      ->excludes(ideal);
  command->add_option("--stride", simulation_.stride, "Use every N-th frame")
      ->type_name("N")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_flag("--color", simulation_.include_color, "Include colour images");
  AddUploadRunOptions(command, &options_);
  command->callback([this] { context_->action = [this] { return Run(); }; });
}

absl::Status SimulateCommand::Run() const {
  SimulationOptions simulation = simulation_;
  simulation.source = options_.source;
  if (!directory_.empty()) return Write(simulation);
  if (options_.map.empty()) {
    return absl::InvalidArgumentError("expected a map to upload to, or --write DIR");
  }
  return Upload(simulation);
}

absl::Status SimulateCommand::Upload(const SimulationOptions& simulation) const {
  const absl::StatusOr<std::unique_ptr<SimulatedFrameSource>> source =
      SimulatedFrameSource::Open(route_, simulation);
  if (!source.ok()) return source.status();
  return RunUpload(options_, source->get(), context_);
}

absl::Status SimulateCommand::Write(const SimulationOptions& simulation) const {
  const absl::StatusOr<Route> route = MakeRoute(route_);
  if (!route.ok()) return route.status();
  const std::size_t frame_total = Simulation(*route, simulation).frame_count();
  ProgressReport report(
      &context_->err, context_->err_is_terminal, "written", frame_total, SteadySeconds);
  absl::Status status = WriteTorwicFolder(*route, directory_, simulation, [&](std::size_t written) {
    report.Update(written, written);
  });
  report.End();
  if (!status.ok()) return status;
  context_->out << frame_total << " frames written to " << directory_ << '\n';
  return absl::OkStatus();
}

}  // namespace steadymap
