#include "client/cli/map_commands.h"

#include <vector>

#include <CLI/CLI.hpp>

#include "client/cli/argument_text.h"
#include "client/cli/class_table_file.h"
#include "client/cli/enumerator_text.h"
#include "client/cli/map_text.h"
#include "client/map_client.h"
#include "core/error.h"
#include "proto/convert_map.h"

namespace steadymap {
namespace {

constexpr char kNameHelp[] = "Id of the map in the tenant `default`, or tenants/T/maps/M";

// Truncations that the server takes, in voxels, and the one it takes when it has the choice.
constexpr double kMinTruncationVoxels = 2.0;
constexpr double kMaxTruncationVoxels = 16.0;
constexpr double kUsualTruncationVoxels = 3.0;

// The default truncation where the voxel size allows it.
double DefaultTruncation(const MapConfig& config) {
  const double voxels = config.truncation_m / config.voxel_size_m;
  if (voxels >= kMinTruncationVoxels && voxels <= kMaxTruncationVoxels) return config.truncation_m;
  return kUsualTruncationVoxels * config.voxel_size_m;
}

}  // namespace

MapCommands::MapCommands(CLI::App* app, CommandContext* context) : context_(context) {
  CLI::App* const map = app->add_subcommand("map", "Create, list, show and delete maps");
  map->require_subcommand(1);
  AddCreate(map);
  AddList(map);
  AddGet(map);
  AddDelete(map);
}

void MapCommands::AddCreate(CLI::App* map) {
  CLI::App* const command = map->add_subcommand("create", "Create an empty map");
  command->footer(
      "How a map is built is fixed here, so that its frames always lead to the same map.\n"
      "The truncation's default is 0.15 m, or three voxels where 0.15 m is not 2 to 16 of them.\n"
      "--classes names a text file with a line `ID NAME [static|semi-static|dynamic|background]` a "
      "class;\n"
      "pixels of dynamic classes are never mapped. Without it the map has the TorWIC classes.");
  command->add_option("NAME", name_, kNameHelp)->required();
  command->add_option("--voxel-size", config_.voxel_size_m, "Edge of a voxel, metres, 0.001 to 1")
      ->capture_default_str();
  command
      ->add_option_function<double>(
          "--truncation",
          [this](const double& truncation_m) {
            config_.truncation_m = truncation_m;
            truncation_given_ = true;
          },
          "Distances are kept within this of a surface, metres, 2 to 16 voxels")
      ->default_str("0.15");
  command
      ->add_option("--policy",
                   policy_,
                   "How the map decides what to believe: " + WordsOf(v1::UpdatePolicy_descriptor()))
      ->capture_default_str();
  command->add_option("--classes", classes_file_, "File with the map's class table")
      ->type_name("FILE");
  command
      ->add_option(
          "--max-depth", config_.max_depth_m, "Depth beyond this is not used, metres, 0.1 to 100")
      ->capture_default_str();
  command
      ->add_option("--max-commit-delay",
                   max_commit_delay_ms_,
                   "Show a frame so many milliseconds after it came at the latest, 1 to 60000; the "
                   "server's own, 200 unless told, without it")
      ->type_name("MS")
      ->check(CLI::Range(1, 60'000));
  command->add_flag("--json", as_json_, "Print the map as JSON");
  command->callback([this] { context_->action = [this] { return Create(); }; });
}

void MapCommands::AddList(CLI::App* map) {
  CLI::App* const command = map->add_subcommand("list", "List the maps of a tenant");
  command->add_option("--tenant", tenant_, "Whose maps")->capture_default_str();
  command->add_flag("--json", as_json_, "Print JSON: {\"maps\": [...]}");
  command->callback([this] { context_->action = [this] { return List(); }; });
}

void MapCommands::AddGet(CLI::App* map) {
  CLI::App* const command = map->add_subcommand("get", "Show a map and what it holds");
  command->add_option("NAME", name_, kNameHelp)->required();
  command->add_flag("--json", as_json_, "Print JSON");
  command->callback([this] { context_->action = [this] { return Get(); }; });
}

void MapCommands::AddDelete(CLI::App* map) {
  CLI::App* const command =
      map->add_subcommand("delete", "Delete a map with its log and its history, at once");
  command->add_option("NAME", name_, kNameHelp)->required();
  command->callback([this] { context_->action = [this] { return Delete(); }; });
}

absl::StatusOr<MapConfig> MapCommands::ConfigFromOptions() const {
  MapConfig config = config_;
  const int policy = NumberOf(v1::UpdatePolicy_descriptor(), policy_);
  if (policy == 0) {
    return InvalidField(reason::kBadValue,
                        "policy",
                        "the policy must be one of " + WordsOf(v1::UpdatePolicy_descriptor()) +
                            ", got \"" + policy_ + "\"");
  }
  const absl::StatusOr<UpdatePolicy> known = FromProto(static_cast<v1::UpdatePolicy>(policy));
  if (!known.ok()) return known.status();
  config.policy = *known;
  if (!truncation_given_) config.truncation_m = DefaultTruncation(config);
  if (!classes_file_.empty()) {
    absl::StatusOr<std::vector<SemanticClass>> classes = LoadClassTable(classes_file_);
    if (!classes.ok()) return classes.status();
    config.classes = *std::move(classes);
  }
  // Here rather than on the server, which takes zeros for "the default".
  const absl::Status status = ValidateMapConfig(config);
  if (!status.ok()) return status;
  return config;
}

absl::Status MapCommands::Create() const {
  const absl::StatusOr<MapName> name = ParseMapArgument(name_);
  if (!name.ok()) return name.status();
  const absl::StatusOr<MapConfig> config = ConfigFromOptions();
  if (!config.ok()) return config.status();
  const absl::StatusOr<v1::Map> map =
      MapClient(context_->Channel())
          .CreateMap(*name, ToProto(*config), std::chrono::milliseconds(max_commit_delay_ms_));
  if (!map.ok()) return map.status();
  if (as_json_) {
    JsonWriter json;
    WriteMapJson(*map, &json);
    context_->out << json.Finish();
  } else {
    context_->out << "created " << map->name() << '\n';
  }
  return absl::OkStatus();
}

absl::Status MapCommands::Get() const {
  const absl::StatusOr<MapName> name = ParseMapArgument(name_);
  if (!name.ok()) return name.status();
  const absl::StatusOr<v1::Map> map = MapClient(context_->Channel()).GetMap(*name);
  if (!map.ok()) return map.status();
  if (as_json_) {
    JsonWriter json;
    WriteMapJson(*map, &json);
    context_->out << json.Finish();
  } else {
    WriteMapText(*map, &context_->out);
  }
  return absl::OkStatus();
}

absl::Status MapCommands::List() const {
  if (!IsValidId(tenant_)) {
    return absl::InvalidArgumentError(
        "expected a tenant's id, lower-case letters, digits and hyphens beginning with a letter, "
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
  JsonWriter json;
  json.BeginObject().Key("maps").BeginArray();
  for (const v1::Map& map : *maps) WriteMapJson(map, &json);
  json.EndArray().EndObject();
  context_->out << json.Finish();
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
