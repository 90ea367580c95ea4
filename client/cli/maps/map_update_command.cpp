#include "client/cli/maps/map_update_command.h"

#include <map>
#include <utility>

#include <CLI/CLI.hpp>
#include <absl/strings/str_cat.h>

#include "client/cli/maps/class_table_file.h"
#include "client/cli/maps/map_text.h"
#include "client/cli/text/argument_text.h"
#include "client/map/map_change.h"
#include "proto/convert_map.h"

namespace steadymap {
namespace {

constexpr char kUpdateFooter[] =
    "Properties that are not given do not change. --classes takes a file in the format of\n"
    "`steadymap map create`: its rows are added to the map's class table and apply to later\n"
    "frames. The file may repeat existing rows, but cannot change them. If another client\n"
    "changes the map at the same time, both changes are applied, unless --etag restricts the\n"
    "change to one state of the map.";

absl::StatusOr<std::vector<v1::SemanticClass>> LoadClasses(const std::string& file) {
  absl::StatusOr<std::vector<SemanticClass>> classes = LoadClassTable(file);
  if (!classes.ok()) return classes.status();
  MapConfig config;
  config.classes = *std::move(classes);
  const v1::MapConfig message = ToProto(config);
  return std::vector<v1::SemanticClass>(message.classes().begin(), message.classes().end());
}

}  // namespace

MapUpdateCommand::MapUpdateCommand(CLI::App* map, CommandContext* context) : context_(context) {
  CLI::App* const command =
      map->add_subcommand("update", "Change a map's labels or world frame, or add classes");
  command->footer(kUpdateFooter);
  command->add_option("NAME", name_, "The map")->required();
  command->add_option("--label", labels_, "Add or change a label; may be given several times")
      ->allow_extra_args(false)
      ->type_name("KEY=VALUE");
  command
      ->add_option("--remove-label",
                   removed_labels_,
                   "Remove a label if the map has it; may be given several times")
      ->allow_extra_args(false)
      ->type_name("KEY");
  command
      ->add_option("--world-frame",
                   world_description_,
                   "Description of the map's origin and of the direction of x")
      ->type_name("TEXT");
  command->add_option("--classes", classes_file_, "File with classes to add")->type_name("FILE");
  command->add_option("--etag", etag_, "Fail if the etag of the map differs from this one")
      ->type_name("ETAG");
  command->add_flag("--json", as_json_, "Print the map as JSON");
  command->callback([this] { context_->action = [this] { return Run(); }; });
}

absl::Status MapUpdateCommand::Run() const {
  const absl::StatusOr<MapName> name = ParseMapArgument(name_);
  if (!name.ok()) return name.status();
  MapChange change{
      .removed_labels = removed_labels_, .world_description = world_description_, .etag = etag_};
  absl::StatusOr<std::map<std::string, std::string>> labels = ParseLabels(labels_);
  if (!labels.ok()) return labels.status();
  change.labels = *std::move(labels);
  for (const std::string& key : removed_labels_) {
    if (!change.labels.contains(key)) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("expected the label \"", key, "\" in only one of --label and --remove-label"));
  }
  if (classes_file_) {
    absl::StatusOr<std::vector<v1::SemanticClass>> classes = LoadClasses(*classes_file_);
    if (!classes.ok()) return classes.status();
    change.classes = *std::move(classes);
  }
  if (change.is_empty()) {
    return absl::InvalidArgumentError(
        "expected at least one of --label, --remove-label, --world-frame and --classes");
  }
  const absl::StatusOr<v1::Map> map = ChangeMap(context_->Channels(), *name, change);
  if (!map.ok()) return map.status();
  WriteChangedMap("updated", *map, as_json_, &context_->out);
  return absl::OkStatus();
}

}  // namespace steadymap
