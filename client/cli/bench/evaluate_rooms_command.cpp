#include "client/cli/bench/evaluate_rooms_command.h"

#include <algorithm>
#include <string_view>

#include <CLI/CLI.hpp>

#include "client/bench/evaluation/method/method.h"
#include "client/bench/evaluation/room/room_evaluation.h"
#include "client/cli/bench/parameter_option.h"
#include "client/cli/text/argument_text.h"
#include "client/cli/upload/progress_report.h"

namespace steadymap {
namespace {

constexpr char kFooter[] =
    "Each case is a room with a wall, a shelf, a table and a few boxes, one of which is changed\n"
    "between two drives. A case is exact if the map reports just the true events, one for each\n"
    "change and one creation for each object, and has just the true objects; of shelf and table,\n"
    "which a drive may hardly see, none may be double. The first case of each change has the\n"
    "default setting: 5 cm voxels, 5 Hz, a level camera that goes around the things at 0.6 m,\n"
    "class labels (of things that touch: instances), range noise of 0.5 %, true poses, no stop\n"
    "of 15 s half way on each drive. In the others, each property differs with a probability of a\n"
    "third. The column `cuboids` counts exact cases in which every cuboid is within 3 cm, half a\n"
    "voxel and the pose error of the truth; `poses` is the RMS error of the camera and of two\n"
    "points 2 m in front of it, without a motion common to all frames, for the claimed and the\n"
    "registered poses, and of the registered ones in the standard deviations that are stated for\n"
    "them: 1 if these are right.\n\n"
    "Changes:";

std::vector<std::string> ChangeNames() {
  std::vector<std::string> names;
  for (const RoomChange change : AllRoomChanges()) names.emplace_back(NameOf(change));
  return names;
}

}  // namespace

EvaluateRoomsCommand::EvaluateRoomsCommand(CLI::App* app, CommandContext* context)
    : context_(context) {
  CLI::App* const command = app->add_subcommand(
      "evaluate-rooms", "Score events and objects of maps of many small rooms with changes");
  std::string footer = kFooter;
  for (const std::string& name : ChangeNames()) footer += "\n  " + name;
  command->footer(footer);
  command->add_option("--change", changes_, "Changes to evaluate (default: all)")
      ->check(CLI::IsMember(ChangeNames()));
  command->add_option("--cases", cases_, "Number of cases per change")
      ->type_name("N")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command
      ->add_option("--variation",
                   variations_,
                   "Properties of all cases, instead of drawn ones; the others are as in the "
                   "default setting. Leaves out changes that do not allow them")
      ->type_name("NAME")
      ->check(CLI::IsMember(RoomVariationNames()));
  command->add_option("--seed", seed_, "Seed of the settings and of all noise")
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--policy", policy_, "Update policy of the maps")
      ->check(CLI::IsMember(MethodNames()))
      ->capture_default_str();
  command
      ->add_option("--labels",
                   labels_,
                   "Labels of all cases (default: drawn for each); leaves out changes that cannot "
                   "be told with them")
      ->check(CLI::IsMember(RoomLabelNames()));
  AddParameterOption(command, &parameters_);
  command->add_flag("--faults", with_faults_, "List what is wrong in each case");
  command->callback([this] { context_->action = [this] { return Run(); }; });
}

absl::Status EvaluateRoomsCommand::Run() const {
  RoomEvaluationOptions options;
  if (!changes_.empty()) {
    std::erase_if(options.changes, [this](RoomChange change) {
      return std::find(changes_.begin(), changes_.end(), NameOf(change)) == changes_.end();
    });
  }
  const absl::StatusOr<ParameterValues> parameters = ParseParameters(parameters_);
  if (!parameters.ok()) return parameters.status();
  MapConfig base;
  base.parameters = *parameters;
  const absl::StatusOr<std::vector<Method>> methods = SelectMethods({policy_}, base);
  if (!methods.ok()) return methods.status();
  for (const Method& method : *methods) {
    if (method.name != policy_) continue;
    options.policy = method.config.policy;
    options.parameters = method.config.parameters;
  }
  options.labels = FindRoomLabels(labels_);
  options.cases = cases_;
  options.variations = variations_;
  options.seed = seed_;
  ProgressReport report(&context_->err,
                        context_->err_is_terminal,
                        "evaluated",
                        options.changes.size() * cases_,
                        SteadySeconds,
                        "cases");
  std::size_t done = 0;
  options.on_case = [&report, &done] {
    ++done;
    report.Update(done, done);
  };
  const absl::StatusOr<std::vector<RoomResult>> results = EvaluateRooms(options);
  report.End();
  if (!results.ok()) return results.status();
  context_->out << RoomTable(*results, with_faults_);
  return absl::OkStatus();
}

}  // namespace steadymap
