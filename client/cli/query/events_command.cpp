#include "client/cli/query/events_command.h"

#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "client/cli/query/object_text.h"
#include "client/cli/text/argument_text.h"
#include "client/cli/text/enumerator_text.h"
#include "client/cli/text/json_text.h"

namespace steadymap {
namespace {

constexpr char kEventsFooter[] =
    "A TIME is in the format of the listing, 2024-05-01T12:00:00Z, or in seconds since 1970.\n\n"
    "JSON: {\"revision\", \"events\": [{\"number\", \"type\", \"reason\", \"object\",\n"
    "\"class\", \"class_name\", \"time\" (capture time), \"revision\", \"center\" [x, y, z];\n"
    "for moves also \"old_center\", \"new_center\", \"confidence\", and \"pose_before\" and\n"
    "\"pose_after\" of the object's frame if its shape was recognised; \"related\" for moves,\n"
    "merges, splits and removed parts, the other object: for a move, the object that was created\n"
    "at the new place and is merged into this one; for robots \"robot\", for objects \"views\" "
    "and\n"
    "\"absences\", the evidence so far, and \"before\" and \"after\", the belief}]}. `class`\n"
    "is the id in the map's class table. Lengths are metres in the world frame, times seconds\n"
    "since 1970.";

}  // namespace

EventsCommand::EventsCommand(CLI::App* app, CommandContext* context) : context_(context) {
  CLI::App* const command =
      app->add_subcommand("events", "List the events of the objects and robots of a map");
  command->footer(kEventsFooter);
  command->add_option("NAME", map_, "The map")->required();
  command
      ->add_option("--type",
                   types_,
                   "Only this type (" + WordsOf(v1::EventType_descriptor()) +
                       "); may be given several times")
      ->allow_extra_args(false)
      ->type_name("TYPE");
  command->add_option("--object", objects_, "Only this object; may be given several times")
      ->check(CLI::NonNegativeNumber)
      ->allow_extra_args(false)
      ->type_name("ID");
  command->add_option("--class", classes_, "Only this class; may be given several times")
      ->allow_extra_args(false)
      ->type_name("ID|NAME");
  command->add_option("--changed-since", changed_since_, "Only events after this revision")
      ->check(CLI::NonNegativeNumber)
      ->type_name("REVISION");
  command->add_option("--since", since_, "Only events of frames captured at this time or later")
      ->type_name("TIME");
  command->add_option("--until", until_, "Only events of frames captured before this time")
      ->type_name("TIME");
  command->add_flag("--json", as_json_, "Print JSON");
  command->callback([this] { context_->action = [this] { return Run(); }; });
}

absl::StatusOr<EventQuery> EventsCommand::ReadQuery() const {
  EventQuery query;
  query.changed_since = Revision(changed_since_);
  query.objects.reserve(objects_.size());
  for (const std::uint64_t object : objects_) query.objects.emplace_back(object);
  for (const std::string& text : types_) {
    const absl::StatusOr<v1::EventType> type = ParseEventType(text);
    if (!type.ok()) return type.status();
    query.types.push_back(*type);
  }
  for (const auto& [text, bound] :
       {std::pair(&since_, &query.start), std::pair(&until_, &query.end)}) {
    if (!text->has_value()) continue;
    const absl::StatusOr<Timestamp> moment = ParseTime(**text);
    if (!moment.ok()) return moment.status();
    *bound = *moment;
  }
  return query;
}

absl::Status EventsCommand::Run() const {
  const absl::StatusOr<MapName> name = ParseMapArgument(map_);
  if (!name.ok()) return name.status();
  absl::StatusOr<EventQuery> query = ReadQuery();
  if (!query.ok()) return query.status();
  MapClient client(context_->Channel());
  const absl::StatusOr<v1::Map> map = client.GetMap(*name);
  if (!map.ok()) return map.status();
  const ClassNames names(map->config());
  absl::StatusOr<std::vector<ClassId>> classes = names.ParseAll(classes_);
  if (!classes.ok()) return classes.status();
  query->classes = *std::move(classes);
  const absl::StatusOr<MapList<v1::ObjectEvent>> events = client.ListEvents(*name, *query);
  if (!events.ok()) return events.status();
  if (as_json_) {
    context_->out << IndentedJson(ListJson(*events, "events", names, EventJson));
  } else {
    WriteEventLines(events->entries, names, &context_->out);
  }
  return absl::OkStatus();
}

}  // namespace steadymap
