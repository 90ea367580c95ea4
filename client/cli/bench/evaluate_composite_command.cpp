#include "client/cli/bench/evaluate_composite_command.h"

#include <optional>

#include <CLI/CLI.hpp>

#include "client/bench/evaluation/composite/composite_evaluation.h"
#include "client/cli/bench/parameter_option.h"
#include "client/cli/text/argument_text.h"
#include "client/cli/upload/progress_report.h"
#include "client/dataset/dataset.h"

namespace steadymap {
namespace {

constexpr char kCompositeFooter[] =
    "Plays a recording as two drives through one room, its frames with even and those with odd\n"
    "indices, and draws six things into them: two are moved between the drives, by 10 to 30 cm\n"
    "and by 30 cm to 1 m, one is turned, one removed, one added, and one stays. They stand on\n"
    "level surface in view, hide what is behind them, and are measured with the noise and the\n"
    "shadows of a structured-light camera; all else is as recorded. Case 0 has no things.\n\n"
    "changes: matched one to one by events; a move has two ends. false: ends that events tell\n"
    "without a change. moves: told by one event of type moved. cuboids: of the things that stand\n"
    "at the end, with each face within 4 cm. ghosts: share of surface that things have left, in\n"
    "the map; kept: share of the surface that `static` fuses from the recording alone. pose mm:\n"
    "RMS difference of registered and recorded poses, at the camera and at two points 2 m in\n"
    "front of it, without a motion common to all frames. sigmas: the same in the\n"
    "standard deviations that are stated for the registered poses: 1 if these are right.";

/// Returns the policies that see both drives.
std::vector<std::string> ComparedPolicies() {
  std::vector<std::string> names = MethodNames();
  std::erase(names, "fresh");
  return names;
}

}  // namespace

EvaluateCompositeCommand::EvaluateCompositeCommand(CLI::App* app, CommandContext* context)
    : context_(context) {
  CLI::App* const command = app->add_subcommand(
      "evaluate-composite", "Score maps of a recording into which changes are drawn");
  command->footer(kCompositeFooter);
  command->add_option("PATH", path_, "The recording")->required();
  command->add_option("--format", format_, "Layout of the recording")
      ->type_name("FORMAT")
      ->check(CLI::IsMember(DatasetFormats()))
      ->required();
  command
      ->add_option("--T-world-dataset",
                   T_world_dataset_file_,
                   "Transform from the recording's world frame to one whose z axis is up within "
                   "45 degrees")
      ->type_name("FILE");
  command->add_option("--stride", stride_, "Use every N-th frame")
      ->type_name("N")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--cases", cases_, "Number of cases with things")
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--seed", seed_, "Seed of places, changes and noise")
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--policy", policy_, "Update policy, compared with `static`")
      ->check(CLI::IsMember(ComparedPolicies()))
      ->capture_default_str();
  command->add_option("--labels", labels_, "Labels of the frames: those of the things")
      ->check(CLI::IsMember(RoomLabelNames()))
      ->capture_default_str();
  command->add_option("--map-voxel", voxel_size_m_, "Edge of the maps' voxels")
      ->type_name("METRES")
      ->check(CLI::Range(0.001, 1.0))
      ->capture_default_str();
  command->add_option("--max-depth", max_depth_m_, "Largest depth that the maps use")
      ->type_name("METRES")
      ->check(CLI::Range(0.1, 100.0))
      ->capture_default_str();
  command
      ->add_option(
          "--offset", session_offset_m_, "Length of a constant pose error of the second drive")
      ->type_name("METRES")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  AddParameterOption(command, &parameters_);
  command->add_flag("--faults", with_faults_, "List what is wrong in each case");
  command->callback([this] { context_->action = [this] { return Run(); }; });
}

absl::Status EvaluateCompositeCommand::Run() const {
  absl::StatusOr<ParameterValues> parameters = ParseParameters(parameters_);
  if (!parameters.ok()) return parameters.status();
  MapConfig config;
  config.parameters = *std::move(parameters);
  config.voxel_size_m = voxel_size_m_;
  config.truncation_m = DefaultTruncationM(voxel_size_m_);
  config.max_depth_m = max_depth_m_;
  absl::StatusOr<std::vector<Method>> methods = SelectMethods({policy_}, config);
  if (!methods.ok()) return methods.status();
  std::erase_if(*methods, [](const Method& method) { return method.last_sequence_only; });
  CompositeEvaluationOptions options;
  options.format = format_;
  options.path = path_;
  options.dataset.stride = stride_;
  options.dataset.T_world_dataset_file = T_world_dataset_file_;
  options.dataset.include_color = false;
  options.labels = FindRoomLabels(labels_).value_or(options.labels);
  options.cases = cases_;
  options.seed = seed_;
  options.session_offset_m = session_offset_m_;
  options.methods = *std::move(methods);
  std::optional<ProgressReport> report;
  std::size_t done = 0;
  options.on_frame = [&](std::size_t total) {
    if (!report) {
      report.emplace(&context_->err, context_->err_is_terminal, "mapped", total, SteadySeconds);
    }
    ++done;
    report->Update(done, done);
  };
  const absl::StatusOr<std::vector<CompositeResult>> results = EvaluateComposite(options);
  if (report) report->End();
  if (!results.ok()) return results.status();
  context_->out << CompositeTable(*results, with_faults_);
  return absl::OkStatus();
}

}  // namespace steadymap
