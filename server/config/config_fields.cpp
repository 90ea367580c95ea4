#include "server/config/config_fields.h"

#include <array>
#include <chrono>

namespace steadymap {
namespace {

constexpr std::int64_t kKiB = std::int64_t{1} << 10;
constexpr std::int64_t kMiB = std::int64_t{1} << 20;
constexpr std::int64_t kTiB = std::int64_t{1} << 40;
constexpr std::int64_t kDayS = 86'400;
constexpr std::int64_t kYearS = 365 * kDayS;

constexpr std::array<std::string_view, 4> kLogLevels = {"debug", "info", "warning", "error"};
constexpr std::array<std::string_view, 2> kLogFormats = {"text", "json"};

/// Converts fields of any integer, duration or enumeration type to the few types of a visitor.
class TypedVisitor {
 public:
  explicit TypedVisitor(FieldVisitor* visitor) : visitor_(visitor) {}

  void Integer(const FieldName& field, const IntegerRange& range, std::uint64_t* value) {
    auto number = static_cast<std::int64_t>(*value);
    visitor_->Integer(field, range, &number);
    *value = static_cast<std::uint64_t>(number);
  }

  template <typename Period>
  void Duration(const FieldName& field,
                const IntegerRange& range,
                std::chrono::duration<std::int64_t, Period>* value) {
    std::int64_t count = value->count();
    visitor_->Integer(field, range, &count);
    *value = std::chrono::duration<std::int64_t, Period>(count);
  }

  template <typename Enumeration>
  void Choice(const FieldName& field,
              std::span<const std::string_view> choices,
              Enumeration* value) {
    auto index = static_cast<std::size_t>(*value);
    visitor_->Choice(field, choices, &index);
    *value = static_cast<Enumeration>(index);
  }

 private:
  FieldVisitor* visitor_;
};

void VisitRoot(ServerConfig* config, FieldVisitor* visitor) {
  TypedVisitor typed(visitor);
  visitor->Text({"listen", "Host and port of the gRPC listener; port 0 selects a free port."},
                &config->listen);
  visitor->Text({"data_dir", "Folder of the store; created if it does not exist."},
                &config->data_dir);
  visitor->Flag({"allow_plaintext_remote",
                 "Allows unencrypted connections on an address that other machines can "
                 "reach."},
                &config->allow_plaintext_remote);
  visitor->Flag({"reflection", "Enables gRPC server reflection, for grpcurl and similar tools."},
                &config->reflection);
  visitor->Flag({"channelz",
                 "Enables gRPC channelz, for debugging connections. Exposes the addresses "
                 "of peers to every client."},
                &config->channelz);
  typed.Duration({"drain_timeout_s",
                  "Maximum time from SIGTERM to the end of the process. Must be less than "
                  "TimeoutStopSec of systemd."},
                 {1, 3600},
                 &config->drain_timeout);
}

void VisitLog(LoggingOptions* log, FieldVisitor* visitor) {
  TypedVisitor typed(visitor);
  visitor->Section("log", "The log on stderr. SIGHUP reloads the level.");
  typed.Choice({"level", "Lowest severity that is written."}, kLogLevels, &log->level);
  typed.Choice({"format", "Format of a log line: text for people, or one JSON object per line."},
               kLogFormats,
               &log->format);
}

void VisitLimits(LimitOptions* limits, FieldVisitor* visitor) {
  TypedVisitor typed(visitor);
  visitor->Section("limits",
                   "Limits on the use of the server by clients. SIGHUP reloads all of them "
                   "except max_message_bytes.");
  typed.Integer({"max_message_bytes", "Maximum size of an accepted message in bytes."},
                {64 * kKiB, 256 * kMiB},
                &limits->max_message_bytes);
  typed.Integer({"max_connections",
                 "Maximum number of simultaneous connections. The limit on open files "
                 "(ulimit -n) also bounds them; a part of it is reserved for the store."},
                {1, 1'000'000},
                &limits->max_connections);
  typed.Integer({"max_upload_streams",
                 "Maximum number of simultaneous upload streams, all maps together. 0: one "
                 "per 512 KiB of queue_bytes_total, and at least 16."},
                {0, 1'000'000},
                &limits->max_upload_streams);
  typed.Integer({"upload_window_frames",
                 "Maximum number of in-flight frames of one upload stream. Must cover the "
                 "frames of a commit interval, or the robot waits for acknowledgements."},
                {1, 10'000},
                &limits->upload_window_frames);
  typed.Integer({"upload_window_bytes",
                 "Maximum number of in-flight bytes of one upload stream; at least "
                 "max_message_bytes."},
                {64 * kKiB, 4096 * kMiB},
                &limits->upload_window_bytes);
  typed.Integer({"queue_bytes_per_map",
                 "Maximum number of bytes of frames that wait for the integration into one "
                 "map."},
                {64 * kKiB, kTiB},
                &limits->queue_bytes_per_map);
  typed.Integer({"queue_bytes_total",
                 "Maximum number of bytes of frames that wait for integration, all maps "
                 "together. Messages that wait for decoding may use half as much in "
                 "addition."},
                {64 * kKiB, kTiB},
                &limits->queue_bytes_total);
  typed.Integer({"memory_bytes",
                 "Maximum number of bytes of memory of the whole process. Above it, "
                 "uploads and new maps are refused with MEMORY_LOW. 0: three quarters of "
                 "the memory of the machine or of the limit of the control group."},
                {0, 1024 * kTiB},
                &limits->memory_bytes);
}

void VisitCommit(CommitOptions* commit, FieldVisitor* visitor) {
  TypedVisitor typed(visitor);
  visitor->Section("commit",
                   "When integrated frames become visible and durable. Does not change the "
                   "content of a map.");
  typed.Integer({"max_frames", "A revision is committed after this many frames."},
                {1, 10'000},
                &commit->max_frames);
  typed.Duration(
      {"max_delay_ms", "A revision is committed at the latest this long after its first frame."},
      {1, 60'000},
      &commit->max_delay);
}

void VisitSessions(SessionOptions* sessions, FieldVisitor* visitor) {
  TypedVisitor typed(visitor);
  visitor->Section("sessions",
                   "When the session of a robot ends, after which a pocd map decides what the "
                   "robot has seen.");
  typed.Duration({"max_silence_s",
                  "A session also ends this long after its last frame if the robot did not "
                  "end its upload, for example because it was switched off."},
                 {1, kDayS},
                 &sessions->max_silence);
}

void VisitRetention(RetentionOptions* retention, FieldVisitor* visitor) {
  TypedVisitor typed(visitor);
  visitor->Section("retention", "Retention of data that the current map no longer needs.");
  typed.Duration({"frame_log_age_s",
                  "Integrated frames are removed from the log after this time, unless the "
                  "map has its own setting. 0: immediately."},
                 {0, 100 * kYearS},
                 &retention->frame_log_age);
  typed.Integer({"frame_log_bytes",
                 "The oldest integrated frames are removed from the log when it exceeds "
                 "this number of bytes, unless the map has its own setting."},
                {0, 1024 * kTiB},
                &retention->frame_log_bytes);
  typed.Duration({"session_idle_s",
                  "Upload sessions are deleted when idle for this long. A frame that is "
                  "sent again after that would be integrated twice."},
                 {7 * kDayS, 100 * kYearS},
                 &retention->session_idle);
  typed.Duration({"trim_interval_s", "Interval at which the retention is applied."},
                 {1, kDayS},
                 &retention->trim_interval);
}

void VisitWatch(WatchServiceOptions* watch, FieldVisitor* visitor) {
  TypedVisitor typed(visitor);
  visitor->Section("watch", "Limits on watches.");
  typed.Integer({"max_watches", "Maximum number of simultaneous watches, all maps together."},
                {1, 1'000'000},
                &watch->max_watches);
  typed.Integer({"openings_per_second",
                 "Watches that one IP address may open per second, after a burst of twice "
                 "max_watches."},
                {1, 1'000'000},
                &watch->openings_per_second);
  typed.Duration({"stall_timeout_s",
                  "A watch, export or section stream whose client reads nothing for this "
                  "long ends with SLOW_CONSUMER. A watch can be resumed."},
                 {1, kDayS},
                 &watch->stall_timeout);
}

void VisitStore(StoreOptions* store, FieldVisitor* visitor) {
  TypedVisitor typed(visitor);
  visitor->Section("store",
                   "The RocksDB databases in data_dir, and the retention of each map's "
                   "history.");
  typed.Integer({"block_cache_bytes", "Size of RocksDB's block cache in bytes."},
                {kMiB, kTiB},
                &store->block_cache_bytes);
  typed.Integer({"write_buffer_bytes",
                 "Size of RocksDB's write buffers in bytes. A restart replays up to twice "
                 "as much."},
                {4 * kMiB, kTiB},
                &store->write_buffer_bytes);
  typed.Integer({"min_free_disk_bytes",
                 "Uploads are refused with DISK_LOW when the disk has fewer free bytes. At "
                 "least three times write_buffer_bytes."},
                {0, 1024 * kTiB},
                &store->min_free_disk_bytes);
  typed.Integer({"log_segment_bytes",
                 "Approximate size in bytes of a file of a map's log. Frames are removed "
                 "in whole files."},
                {64 * kKiB, 4096 * kMiB},
                &store->log_segment_bytes);
  typed.Integer({"kept_poses",
                 "Number of newest frame poses per map that are kept after their frames "
                 "were removed."},
                {0, 1'000'000'000'000},
                &store->kept_poses);
  typed.Integer({"kept_events", "Number of newest events that are kept per map."},
                {1, 1'000'000'000'000},
                &store->kept_events);
  typed.Duration({"change_list_age_s",
                  "Change lists are removed after this time. A watcher further behind must "
                  "start again from a snapshot."},
                 {0, 100 * kYearS},
                 &store->change_list_age);
  typed.Integer({"kept_change_lists", "Maximum number of change lists per map."},
                {1, 100'000'000},
                &store->kept_change_lists);
  typed.Duration({"change_list_grace_s",
                  "Additional time for which change lists are kept if a connected watcher "
                  "still needs them."},
                 {0, 100 * kYearS},
                 &store->change_list_grace);
}

}  // namespace

void VisitFields(ServerConfig* config, FieldVisitor* visitor) {
  VisitRoot(config, visitor);
  VisitLog(&config->log, visitor);
  VisitLimits(&config->limits, visitor);
  VisitCommit(&config->commit, visitor);
  VisitSessions(&config->sessions, visitor);
  VisitRetention(&config->retention, visitor);
  VisitWatch(&config->watch, visitor);
  VisitStore(&config->store, visitor);
}

}  // namespace steadymap
