#include "client/cli/evaluate_command.h"

#include <CLI/CLI.hpp>

#include "client/cli/progress_report.h"
#include "client/evaluation/score_table.h"

namespace steadymap {

EvaluateCommand::EvaluateCommand(CLI::App* app, CommandContext* context) : context_(context) {
  CLI::App* const command = app->add_subcommand("evaluate", "Score maps against the truth");
  command->add_option("--route", routes_, "A simulated route")->required();
  command->add_option("--policy", policies_, "What to compare; all if none is named");
  command->add_option("--seed", seeds_, "Seeds of all noise")->capture_default_str();
  command->add_flag("--ideal", is_ideal_, "A sensor without noise, holes or drift");
  command->add_option("--stride", stride_, "Keep every N-th frame")
      ->type_name("N")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--voxel", voxel_size_m_, "Edge of the voxels that are compared, metres")
      ->type_name("METRES")
      ->check(CLI::Range(0.02, 1.0));
  command->add_flag("--ground", with_ground_, "Score the ground, too");
  command->callback([this] { context_->action = [this] { return Run(); }; });
}

absl::StatusOr<Evaluation> EvaluateCommand::EvaluateNamedRoute(const std::string& name) const {
  const absl::StatusOr<Route> route = MakeRoute(name);
  if (!route.ok()) return route.status();
  absl::StatusOr<std::vector<Method>> methods = SelectMethods(policies_, MapConfigFor(name));
  if (!methods.ok()) return methods.status();
  RouteEvaluationOptions options;
  options.simulation.sensor = is_ideal_ ? SensorModel::Ideal() : SensorModel::Full();
  options.simulation.stride = stride_;
  options.seeds = seeds_;
  options.voxel_size_m = voxel_size_m_ > 0.0 ? voxel_size_m_ : EvaluationVoxelFor(name);
  options.with_ground = with_ground_;
  options.methods = *std::move(methods);
  return EvaluateRoute(*route, options);
}

absl::Status EvaluateCommand::Run() const {
  for (const std::string& name : routes_) {
    const absl::StatusOr<Evaluation> evaluation = EvaluateNamedRoute(name);
    if (!evaluation.ok()) return evaluation.status();
    context_->out << ScoreTable(*evaluation) << '\n';
  }
  return absl::OkStatus();
}

}  // namespace steadymap
