#include "client/cli/watch/mirror_command.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "client/cli/maps/map_lookup.h"
#include "client/cli/text/argument_text.h"
#include "client/cli/text/error_line.h"
#include "client/cli/text/json_text.h"
#include "client/cli/text/number_text.h"
#include "client/cli/text/output_file.h"
#include "client/cli/text/stop_signal.h"
#include "client/cli/watch/resume_token.h"
#include "core/map/placed_volume.h"
#include "core/query/file_encoder.h"
#include "core/query/vdb_file.h"

namespace steadymap {
namespace {

constexpr char kMapFile[] = "map.vdb";
constexpr char kStateFile[] = "mirror.json";

constexpr char kMirrorFooter[] =
    "FOLDER/map.vdb has the content of `steadymap export --format vdb` and is kept up to date:\n"
    "the background and the present objects, or the part of them selected by the filter, in\n"
    "whole leaves and whole objects. FOLDER/mirror.json describes map.vdb: {map, revision,\n"
    "last_capture_time (seconds since 1970), objects, bytes, resume_token}. When the map has\n"
    "changed, both files are replaced as a whole, map.vdb first, at most every --interval\n"
    "seconds, and one line is printed. SIGINT and SIGTERM end the command with exit code 0.\n\n"
    "The mirror continues after lost connections and server restarts. A new run starts with a\n"
    "snapshot, because a vdb file does not contain all data that a mirror needs. --once writes\n"
    "the files once and ends.";

std::chrono::milliseconds MillisecondsOf(double seconds) {
  return std::chrono::milliseconds(static_cast<std::int64_t>(1e3 * seconds));
}

/// The newest step of a mirror, passed from the mirror's thread to the writing thread.
class NewestStep {
 public:
  explicit NewestStep(StopSignal* wake) : wake_(wake) {}

  void Put(const MirrorStep& step) {
    {
      const std::lock_guard lock(mutex_);
      step_ = step;
    }
    wake_->Notify();
  }

  bool Has() const {
    const std::lock_guard lock(mutex_);
    return step_.has_value();
  }

  std::optional<MirrorStep> Take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(step_, std::nullopt);
  }

 private:
  StopSignal* const wake_;
  mutable std::mutex mutex_;
  std::optional<MirrorStep> step_;
};

std::vector<PlacedVolume> MirroredVolumes(const MapSnapshot& map, const MapFilter& filter) {
  std::vector<PlacedVolume> volumes = ShownVolumes(map);
  if (!filter.ShowsBackground()) volumes.erase(volumes.begin());
  return volumes;
}

/// Writes the output of `encoder` to a file, piece by piece. Returns its length in bytes.
absl::StatusOr<std::uint64_t> WriteEncodedFile(const std::filesystem::path& path,
                                               FileEncoder* encoder) {
  absl::StatusOr<OutputFile> file = OutputFile::Create(path);
  if (!file.ok()) return file.status();
  std::uint64_t bytes = 0;
  for (std::string piece;;) {
    const absl::StatusOr<bool> more = encoder->Next(&piece);
    if (!more.ok()) return more.status();
    if (!*more) break;
    if (absl::Status status = file->Write(piece); !status.ok()) return status;
    bytes += piece.size();
  }
  absl::Status status = file->Sync();
  if (status.ok()) status = file->Commit();
  if (!status.ok()) return status;
  return bytes;
}

absl::Status WriteTextFile(const std::filesystem::path& path, const std::string& text) {
  absl::StatusOr<OutputFile> file = OutputFile::Create(path);
  if (!file.ok()) return file.status();
  absl::Status status = file->Write(text);
  if (status.ok()) status = file->Sync();
  return status.ok() ? file->Commit() : status;
}

}  // namespace

MirrorCommand::MirrorCommand(CLI::App* app, CommandContext* context) : context_(context) {
  CLI::App* const command = app->add_subcommand("mirror", "Keep a map's vdb file up to date");
  command->footer(kMirrorFooter);
  command->add_option("NAME", map_, "The map")->required();
  command->add_option("--output", output_, "The folder for the files; created if it does not exist")
      ->required()
      ->type_name("FOLDER");
  AddWatchFilterOptions(command, &filter_);
  command->add_option("--interval", interval_s_, "Shortest time between two writes, seconds")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  command->add_flag("--once", once_, "Write the files once and end");
  command
      ->add_option("--retry-for",
                   retry_for_s_,
                   "Time for which to retry while the server cannot be reached, seconds")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  command->callback([this] { context_->action = [this] { return Run(); }; });
}

absl::Status MirrorCommand::Run() const {
  const absl::StatusOr<MapName> name = ParseMapArgument(map_);
  if (!name.ok()) return name.status();
  if (absl::Status status = MakeFolder(output_); !status.ok()) return status;
  const absl::StatusOr<v1::Map> map = LookUpMap(*name, RetryTime(retry_for_s_), context_);
  if (!map.ok()) return map.status();
  absl::StatusOr<MapFilter> filter = ReadWatchFilter(filter_, ClassNames(map->config()));
  if (!filter.ok()) return filter.status();
  filter->events = false;
  return Follow(*name, *filter);
}

absl::Status MirrorCommand::Follow(const MapName& name, const MapFilter& filter) const {
  using Clock = std::chrono::steady_clock;
  StopSignal stop;
  NewestStep newest(&stop);
  MirrorOptions options;
  options.filter = filter;
  options.backoff.give_up_after = RetryTime(retry_for_s_);
  MirrorCallbacks callbacks;
  callbacks.on_step = [&](const MirrorStep& step) { newest.Put(step); };
  callbacks.on_state = [&](const WatchStateChange& change) {
    if (change.state == WatchState::kEnded) stop.Notify();
    if (change.state != WatchState::kReconnecting) return;
    context_->err << "the mirror was interrupted (" << ErrorLine(change.status, context_->server)
                  << "); retrying in "
                  << DurationText(1e-3 * static_cast<double>(change.delay.count())) << std::endl;
  };
  const std::unique_ptr<MapMirror> mirror =
      MapMirror::Start(context_->Channels(), name, options, callbacks);

  Clock::time_point next_write = Clock::now();
  for (;;) {
    const bool is_last = stop.came() || !mirror->status().ok();
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(next_write - Clock::now());
    if (newest.Has() && (is_last || left.count() <= 0)) {
      const std::optional<MirrorStep> step = newest.Take();
      absl::Status status = WriteFiles(name, filter, *step->map, step->resume_token);
      if (!status.ok() || once_) return status;
      next_write = Clock::now() + MillisecondsOf(interval_s_);
    } else if (is_last) {
      if (!stop.came()) return mirror->status();
      return once_ ? absl::CancelledError("stopped before the map was received") : absl::OkStatus();
    } else if (newest.Has()) {
      stop.Wait(left);
    } else {
      stop.Wait();
    }
  }
}

absl::Status MirrorCommand::WriteFiles(const MapName& name,
                                       const MapFilter& filter,
                                       const MapSnapshot& map,
                                       const std::string& resume_token) const {
  const std::filesystem::path folder = output_;
  const std::unique_ptr<FileEncoder> encoder =
      MakeVdbEncoder(map, MirroredVolumes(map, filter), std::nullopt);
  const absl::StatusOr<std::uint64_t> bytes = WriteEncodedFile(folder / kMapFile, encoder.get());
  if (!bytes.ok()) return bytes.status();

  const Json state = {{"map", name.ToString()},
                      {"revision", map.revision.value()},
                      {"last_capture_time", map.last_capture_time.seconds()},
                      {"objects", map.objects.size()},
                      {"bytes", *bytes},
                      {"resume_token", ResumeTokenText(resume_token)}};
  absl::Status status = WriteTextFile(folder / kStateFile, IndentedJson(state));
  if (!status.ok()) return status;
  context_->out << (folder / kMapFile).string() << ": " << BytesText(*bytes) << ", revision "
                << map.revision.value() << " of " << name.ToString() << std::endl;
  if (!context_->out) return absl::FailedPreconditionError("cannot write to standard output");
  return absl::OkStatus();
}

}  // namespace steadymap
