#include "client/cli/maps/map_commands.h"

#include <map>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "client/cli/maps/map_text.h"
#include "client/cli/text/argument_text.h"
#include "client/cli/text/json_text.h"
#include "client/map/map_client.h"
#include "proto/convert_map.h"

namespace steadymap {
namespace {

constexpr char kNameHelp[] = "Id of the map in the tenant `default`, or tenants/T/maps/M";

}  // namespace

MapCommands::MapCommands(CLI::App* app, CommandContext* context) : context_(context) {
  CLI::App* const map = app->add_subcommand("map", "Create, list, show, change and delete maps");
  map->require_subcommand(1);
  AddCreate(map);
  AddList(map);
  AddGet(map);
  update_.emplace(map, context);
  AddDelete(map);
}

void MapCommands::AddCreate(CLI::App* map) {
  CLI::App* const command = map->add_subcommand("create", "Create an empty map");
  command->footer(MapOptionsHelp() + "\n\nThe default policy is static.");
  command->add_option("NAME", name_, kNameHelp)->required();
  AddMapOptions(command, &map_options_);
  command
      ->add_option(
          "--max-commit-delay",
          max_commit_delay_ms_,
          "Longest time from the arrival of a frame to its commit, milliseconds, 1 to 60000 "
          "(default: the server's setting, normally 200)")
      ->type_name("MS")
      ->check(CLI::Range(1, 60'000));
  command->add_option("--label", labels_, "Label of the map; may be given several times")
      ->allow_extra_args(false)
      ->type_name("KEY=VALUE");
  command
      ->add_option("--world-frame",
                   world_description_,
                   "Description of the map's origin and of the direction of x")
      ->type_name("TEXT");
  command->add_flag("--json", as_json_, "Print the map as JSON");
  command->callback([this] { context_->action = [this] { return Create(); }; });
}

void MapCommands::AddList(CLI::App* map) {
  CLI::App* const command = map->add_subcommand("list", "List the maps of a tenant");
  command->add_option("--tenant", tenant_, "Id of the tenant")->capture_default_str();
  command->add_flag("--json", as_json_, "Print JSON: {\"maps\": [...]}");
  command->callback([this] { context_->action = [this] { return List(); }; });
}

void MapCommands::AddGet(CLI::App* map) {
  CLI::App* const command =
      map->add_subcommand("get", "Show a map, its configuration and its state");
  command->add_option("NAME", name_, kNameHelp)->required();
  command->add_flag("--json", as_json_, "Print JSON");
  command->callback([this] { context_->action = [this] { return Get(); }; });
}

void MapCommands::AddDelete(CLI::App* map) {
  CLI::App* const command = map->add_subcommand(
      "delete", "Delete a map with its log and its history, without confirmation");
  command->add_option("NAME", name_, kNameHelp)->required();
  command->callback([this] { context_->action = [this] { return Delete(); }; });
}

absl::Status MapCommands::Create() const {
  const absl::StatusOr<MapName> name = ParseMapArgument(name_);
  if (!name.ok()) return name.status();
  const absl::StatusOr<MapConfig> config = ConfigOf(map_options_);
  if (!config.ok()) return config.status();
  absl::StatusOr<std::map<std::string, std::string>> labels = ParseLabels(labels_);
  if (!labels.ok()) return labels.status();
  MapSettings settings{.max_commit_delay = std::chrono::milliseconds(max_commit_delay_ms_),
                       .labels = *std::move(labels)};
  if (world_description_) {
    settings.world_frame.emplace().set_description(*world_description_);
  }
  const absl::StatusOr<v1::Map> map =
      MapClient(context_->Channel()).CreateMap(*name, ToProto(*config), settings);
  if (!map.ok()) return map.status();
  WriteChangedMap("created", *map, as_json_, &context_->out);
  return absl::OkStatus();
}

absl::Status MapCommands::Get() const {
  const absl::StatusOr<MapName> name = ParseMapArgument(name_);
  if (!name.ok()) return name.status();
  const absl::StatusOr<v1::Map> map = MapClient(context_->Channel()).GetMap(*name);
  if (!map.ok()) return map.status();
  if (as_json_) {
    context_->out << IndentedJson(MapJson(*map));
  } else {
    WriteMapText(*map, &context_->out);
  }
  return absl::OkStatus();
}

absl::Status MapCommands::List() const {
  if (!IsValidId(tenant_)) {
    return absl::InvalidArgumentError(
        "expected a tenant id: lower-case letters, digits and hyphens, starting with a letter; "
        "got \"" +
        tenant_ + "\"");
  }
  const absl::StatusOr<std::vector<v1::Map>> maps =
      MapClient(context_->Channel()).ListMaps(tenant_);
  if (!maps.ok()) return maps.status();
  if (!as_json_) {
    WriteMapTable(*maps, &context_->out);
    return absl::OkStatus();
  }
  Json document;
  document["maps"] = Json::array();
  for (const v1::Map& map : *maps) document["maps"].push_back(MapJson(map));
  context_->out << IndentedJson(document);
  return absl::OkStatus();
}

absl::Status MapCommands::Delete() const {
  const absl::StatusOr<MapName> name = ParseMapArgument(name_);
  if (!name.ok()) return name.status();
  absl::Status status = MapClient(context_->Channel()).DeleteMap(*name);
  if (status.ok()) context_->out << "deleted " << name->ToString() << '\n';
  return status;
}

}  // namespace steadymap
