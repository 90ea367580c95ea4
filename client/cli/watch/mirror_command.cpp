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
#include "client/cli/text/json_writer.h"
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
    "FOLDER/map.vdb is what `steadymap export --format vdb` would write, kept up to date: "
    "background\n"
    "and present objects, or what the filter lets pass of them, in whole leaves and whole "
    "objects.\n"
    "FOLDER/mirror.json tells what map.vdb holds: {map, revision, last_capture_time (seconds "
    "since\n"
    "1970), objects, bytes, resume_token}. Both are replaced as a whole, map.vdb first, whenever "
    "the\n"
    "map changed, at most every --interval seconds; a line is printed for each time. SIGINT and "
    "SIGTERM\n"
    "end it, with exit code 0.\n\n"
    "Lost connections and server restarts are survived. Started again it begins with a snapshot, "
    "since\n"
    "a vdb file does not hold all that a mirror needs; --once writes one and ends.";

std::chrono::milliseconds MillisecondsOf(double seconds) {
  return std::chrono::milliseconds(static_cast<std::int64_t>(1e3 * seconds));
}

/// The newest step of a mirror, handed from its thread to the one that writes.
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

/// Makes a file of what `encoder` makes, piece by piece; its length in bytes.
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
  command->add_option("--output", output_, "The folder; made where there is none")
      ->required()
      ->type_name("FOLDER");
  AddWatchFilterOptions(command, &filter_);
  command->add_option("--interval", interval_s_, "Least time from one writing to the next, seconds")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  command->add_flag("--once", once_, "Write the files once and end");
  command
      ->add_option("--retry-for",
                   retry_for_s_,
                   "How long to go on trying while the server cannot be reached, seconds")
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
    context_->err << "the mirror broke off (" << ErrorLine(change.status, context_->server)
                  << "); trying again in "
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
      return once_ ? absl::CancelledError("stopped before the map had come") : absl::OkStatus();
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

  JsonWriter json;
  json.BeginObject();
  json.Key("map").Text(name.ToString());
  json.Key("revision").Integer(map.revision.value());
  json.Key("last_capture_time").Number(map.last_capture_time.seconds());
  json.Key("objects").Integer(map.objects.size());
  json.Key("bytes").Integer(*bytes);
  json.Key("resume_token").Text(ResumeTokenText(resume_token));
  json.EndObject();
  absl::Status status = WriteTextFile(folder / kStateFile, json.Finish());
  if (!status.ok()) return status;
  context_->out << (folder / kMapFile).string() << ": " << BytesText(*bytes) << ", revision "
                << map.revision.value() << " of " << name.ToString() << std::endl;
  if (!context_->out) return absl::FailedPreconditionError("cannot write to standard output");
  return absl::OkStatus();
}

}  // namespace steadymap
