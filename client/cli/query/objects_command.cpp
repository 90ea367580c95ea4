#include "client/cli/query/objects_command.h"

#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "client/cli/query/object_text.h"
#include "client/cli/text/argument_text.h"
#include "client/cli/text/json_text.h"
#include "client/map/map_client.h"

namespace steadymap {
namespace {

constexpr char kObjectsFooter[] =
    "E[v] of an object is the probability that it is still in its place; `alpha` and `beta`\n"
    "are the evidence for and against that. Maps of the static policy have no objects.\n\n"
    "JSON: {\"revision\", \"objects\": [{\"id\", \"class\", \"class_name\",\n"
    "\"class_confidence\", \"standing\", \"center\" and \"size\" [x, y, z] and \"yaw\" of its\n"
    "cuboid, \"stationarity\", \"alpha\", \"beta\", \"change_mean_m\", \"change_std_m\",\n"
    "\"first_seen\", \"last_seen\", \"views\", \"absences\", \"revision\", \"leaves\",\n"
    "\"contradictions\": [{\"present\" and \"absent\" [robot, sensor]: one sees the object, the\n"
    "other one finds it gone; \"since\", \"last\", \"sessions\"}]}]}.\n"
    "`class` is the id in the map's class table. Lengths are metres in the world frame, angles\n"
    "radians, times seconds since 1970.";

}  // namespace

ObjectsCommand::ObjectsCommand(CLI::App* app, CommandContext* context) : context_(context) {
  CLI::App* const command = app->add_subcommand("objects", "List the objects of a map");
  command->footer(kObjectsFooter);
  command->add_option("NAME", map_, "The map")->required();
  command->add_option("--class", classes_, "Only this class; may be given several times")
      ->allow_extra_args(false)
      ->type_name("ID|NAME");
  command->add_option("--box", box_, "Only objects whose cuboid touches the box, metres")
      ->type_name("x0,y0,z0,x1,y1,z1");
  command
      ->add_option("--min-stationarity", min_stationarity_, "Only objects with at least this E[v]")
      ->check(CLI::Range(0.0, 1.0));
  command->add_option("--changed-since", changed_since_, "Only objects changed after this revision")
      ->check(CLI::NonNegativeNumber)
      ->type_name("REVISION");
  command->add_flag("--all", all_, "Include archived and tentative objects");
  command->add_flag("--json", as_json_, "Print JSON");
  command->callback([this] { context_->action = [this] { return Run(); }; });
}

absl::Status ObjectsCommand::Run() const {
  const absl::StatusOr<MapName> name = ParseMapArgument(map_);
  if (!name.ok()) return name.status();
  ObjectQuery query;
  query.min_stationarity = min_stationarity_;
  query.changed_since = Revision(changed_since_);
  query.with_archived_and_tentative = all_;
  if (!box_.empty()) {
    const absl::StatusOr<Box> box = ParseBox(box_);
    if (!box.ok()) return box.status();
    query.box_world = *box;
  }
  MapClient client(context_->Channel());
  const absl::StatusOr<v1::Map> map = client.GetMap(*name);
  if (!map.ok()) return map.status();
  const ClassNames names(map->config());
  absl::StatusOr<std::vector<ClassId>> classes = names.ParseAll(classes_);
  if (!classes.ok()) return classes.status();
  query.classes = *std::move(classes);
  const absl::StatusOr<MapList<v1::Object>> objects = client.ListObjects(*name, query);
  if (!objects.ok()) return objects.status();
  if (as_json_) {
    context_->out << IndentedJson(ListJson(*objects, "objects", names, ObjectJson));
  } else {
    WriteObjectTable(objects->entries, names, &context_->out);
  }
  return absl::OkStatus();
}

}  // namespace steadymap
