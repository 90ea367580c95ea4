#include "client/cli/watch/watch_command.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include <CLI/CLI.hpp>

#include "client/cli/maps/map_lookup.h"
#include "client/cli/text/argument_text.h"
#include "client/cli/text/stop_signal.h"
#include "client/cli/watch/resume_token.h"

namespace steadymap {
namespace {

constexpr char kWatchFooter[] =
    "Prints a line for each event, each new state of an object, each object that is no longer "
    "shown,\n"
    "and the volumes of each step; `progress` ends a step and gives the token to go on from. The "
    "lines\n"
    "of a step appear together, once all of it has come. Lost connections and server restarts are\n"
    "survived: the watch goes on behind its last step. SIGINT and SIGTERM end it, with exit code "
    "0.\n\n"
    "--from now (the default) begins with what happens next, snapshot with all that is there, and "
    "a\n"
    "token, as `progress` gives it, behind the step that it stands for; the filter must be the "
    "same.\n"
    "With --token-file the newest token is kept in a file after each step, and the watch begins "
    "behind\n"
    "the one that the file has; only --from with that same token goes with such a file. Delete it "
    "to\n"
    "begin anew.\n\n"
    "JSON: a document a line, by \"kind\": created {revision, voxel_size_m, truncation_m, "
    "incarnation};\n"
    "event {event} as in `steadymap events --json`; object {revision, object} as in `steadymap "
    "objects\n"
    "--json`; removed {revision, object}; volume {revision, previous_revision, commits,\n"
    "last_capture_time, leaves: [{object, changed, gone}]}, object 0 being the background; resync\n"
    "{revision, reason}: forget everything, the history to go on from was gone; progress "
    "{revision,\n"
    "previous_revision, commits, snapshot, resume_token}.";

absl::Status TwoStarts(const std::string& token_file) {
  return absl::InvalidArgumentError("--from goes with a token file only where it is the token in " +
                                    token_file + "; delete the file to begin anew");
}

}  // namespace

WatchCommand::WatchCommand(CLI::App* app, CommandContext* context) : context_(context) {
  CLI::App* const command = app->add_subcommand("watch", "Print what happens to a map, as it does");
  command->footer(kWatchFooter);
  command->add_option("NAME", map_, "The map")->required();
  AddWatchFilterOptions(command, &filter_);
  command->add_option("--kinds", kinds_, "Only these (events, objects, volume), by commas")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember({"events", "objects", "volume"}))
      ->type_name("KINDS");
  command->add_flag("--archived", archived_, "Archived objects too");
  command->add_option("--from", from_, "Where to begin (now, snapshot, or a token)")
      ->type_name("TOKEN|snapshot|now");
  command->add_option("--token-file", token_file_, "Keep the newest token there, and go on from it")
      ->type_name("FILE");
  command->add_option("--until-revision", until_revision_, "End once this revision is reached")
      ->check(CLI::PositiveNumber)
      ->type_name("REVISION");
  command->add_option("--count", count_, "End after so many steps")
      ->check(CLI::PositiveNumber)
      ->type_name("N");
  command
      ->add_option("--retry-for",
                   retry_for_s_,
                   "How long to go on trying while the server cannot be reached, seconds")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  command->add_flag("--json", as_json_, "Print JSON, a document a line");
  command->callback([this] { context_->action = [this] { return Run(); }; });
}

absl::StatusOr<WatchOptions> WatchCommand::ReadStart() const {
  WatchOptions options;
  options.start = WatchOpening::kNow;
  if (!token_file_.empty()) {
    absl::StatusOr<std::string> kept = ReadTokenFile(token_file_);
    if (!kept.ok()) return kept.status();
    options.resume_token = *std::move(kept);
  }
  const bool is_kept = !options.resume_token.empty();
  if (from_ == "snapshot" || from_ == "now") {
    if (is_kept) return TwoStarts(token_file_);
    if (from_ == "snapshot") options.start = WatchOpening::kSnapshot;
  } else if (!from_.empty()) {
    absl::StatusOr<std::string> given = ParseResumeToken(from_);
    if (!given.ok()) return given.status();
    if (is_kept && options.resume_token != *given) return TwoStarts(token_file_);
    options.resume_token = *std::move(given);
  }
  if (!options.resume_token.empty()) options.start = WatchOpening::kResume;
  options.backoff.give_up_after = RetryTime(retry_for_s_);
  return options;
}

absl::StatusOr<MapFilter> WatchCommand::ReadFilter(const ClassNames& names) const {
  absl::StatusOr<MapFilter> filter = ReadWatchFilter(filter_, names);
  if (!filter.ok()) return filter;
  const auto wants = [this](const char* kind) {
    return kinds_.empty() || std::find(kinds_.begin(), kinds_.end(), kind) != kinds_.end();
  };
  filter->events = wants("events");
  filter->states = wants("objects");
  filter->volumes = wants("volume");
  filter->archived = archived_;
  return filter;
}

absl::Status WatchCommand::Run() const {
  const absl::StatusOr<MapName> name = ParseMapArgument(map_);
  if (!name.ok()) return name.status();
  absl::StatusOr<WatchOptions> options = ReadStart();
  if (!options.ok()) return options.status();
  const absl::StatusOr<v1::Map> map = LookUpMap(*name, RetryTime(retry_for_s_), context_);
  if (!map.ok()) return map.status();
  const ClassNames names(map->config());
  absl::StatusOr<MapFilter> filter = ReadFilter(names);
  if (!filter.ok()) return filter.status();
  options->filter = *std::move(filter);

  WatchPrinterOptions printing;
  printing.as_json = as_json_;
  printing.token_file = token_file_;
  if (until_revision_ > 0) printing.until_revision = until_revision_;
  if (count_ > 0) printing.count = count_;
  StopSignal stop;
  WatchPrinter printer(printing, &names, context_, &stop);
  const MapWatch watch(context_->Channels(), *name, *std::move(options), &printer);
  while (!printer.is_done() && !stop.came()) stop.Wait();
  return printer.result();
}

}  // namespace steadymap
