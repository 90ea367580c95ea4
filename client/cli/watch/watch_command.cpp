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
    "Prints one line for each event, each new state of an object, each object that is no\n"
    "longer shown, and the volumes of each step. `progress` ends a step and contains its\n"
    "resume token. The lines of a step are printed together, when the step is complete. The\n"
    "watch continues after lost connections and server restarts, from the last complete step.\n"
    "SIGINT and SIGTERM end it with exit code 0.\n\n"
    "--from now (the default) starts with the next change, --from snapshot with the current\n"
    "map, and --from TOKEN after the step whose `progress` contains the token, with the same\n"
    "filter. With --token-file, the newest token is stored in a file after each step, and the\n"
    "watch starts after the stored token. --from is then allowed only with the same token.\n"
    "Delete the file to start again without it.\n\n"
    "JSON: one document per line, by \"kind\": created {revision, voxel_size_m, truncation_m,\n"
    "incarnation}; event {event} as in `steadymap events --json`; object {revision, object} as\n"
    "in `steadymap objects --json`; removed {revision, object}; volume {revision,\n"
    "previous_revision, commits, last_capture_time, leaves: [{object, changed, gone}]}, where\n"
    "object 0 is the background; resync {revision, reason}: discard all earlier content,\n"
    "because the history after the token was dropped; progress {revision, previous_revision,\n"
    "commits, snapshot, resume_token}.";

absl::Status ConflictingStartError(const std::string& token_file) {
  return absl::InvalidArgumentError(
      "--from can be combined with a token file only if it is the token in " + token_file +
      "; delete the file to start without it");
}

}  // namespace

WatchCommand::WatchCommand(CLI::App* app, CommandContext* context) : context_(context) {
  CLI::App* const command =
      app->add_subcommand("watch", "Print the changes of a map as they occur");
  command->footer(kWatchFooter);
  command->add_option("NAME", map_, "The map")->required();
  AddWatchFilterOptions(command, &filter_);
  command
      ->add_option(
          "--kinds", kinds_, "Only these kinds (events, objects, volume), separated by commas")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember({"events", "objects", "volume"}))
      ->type_name("KINDS");
  command->add_flag("--archived", archived_, "Include archived objects");
  command->add_option("--from", from_, "Start of the watch (now, snapshot, or a token)")
      ->type_name("TOKEN|snapshot|now");
  command
      ->add_option(
          "--token-file", token_file_, "Store the newest token in this file, and resume from it")
      ->type_name("FILE");
  command->add_option("--until-revision", until_revision_, "End when this revision is reached")
      ->check(CLI::PositiveNumber)
      ->type_name("REVISION");
  command->add_option("--count", count_, "End after this number of steps")
      ->check(CLI::PositiveNumber)
      ->type_name("N");
  command
      ->add_option("--retry-for",
                   retry_for_s_,
                   "Time for which to retry while the server cannot be reached, seconds")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  command->add_flag("--json", as_json_, "Print JSON, one document per line");
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
    if (is_kept) return ConflictingStartError(token_file_);
    if (from_ == "snapshot") options.start = WatchOpening::kSnapshot;
  } else if (!from_.empty()) {
    absl::StatusOr<std::string> given = ParseResumeToken(from_);
    if (!given.ok()) return given.status();
    if (is_kept && options.resume_token != *given) return ConflictingStartError(token_file_);
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
