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
  visitor->Text({"listen", "Host and port of the gRPC listener; port 0 takes a free one."},
                &config->listen);
  visitor->Text({"data_dir", "Folder of the store; made if it does not exist."}, &config->data_dir);
  visitor->Flag({"allow_plaintext_remote",
                 "Whether plain text may be spoken on an address that other machines can reach."},
                &config->allow_plaintext_remote);
  visitor->Flag({"reflection", "gRPC server reflection, for grpcurl and the like."},
                &config->reflection);
  visitor->Flag({"channelz",
                 "gRPC channelz, for debugging connections. Shows peers' addresses to every "
                 "client."},
                &config->channelz);
  typed.Duration({"drain_timeout_s",
                  "Longest time from SIGTERM to the end. systemd's TimeoutStopSec must exceed it."},
                 {1, 3600},
                 &config->drain_timeout);
}

void VisitLog(LoggingOptions* log, FieldVisitor* visitor) {
  TypedVisitor typed(visitor);
  visitor->Section("log", "What the daemon says on stderr. SIGHUP reloads the level.");
  typed.Choice({"level", "Lowest severity that is written."}, kLogLevels, &log->level);
  typed.Choice({"format", "How a line looks: for people, or one JSON object a line."},
               kLogFormats,
               &log->format);
}

void VisitLimits(LimitOptions* limits, FieldVisitor* visitor) {
  TypedVisitor typed(visitor);
  visitor->Section("limits", "What clients may ask for. SIGHUP reloads all of it.");
  typed.Integer({"max_message_bytes", "Largest message that is taken."},
                {64 * kKiB, 256 * kMiB},
                &limits->max_message_bytes);
  typed.Integer({"max_connections",
                 "Connections at once; a part of the files that the process may open bounds them "
                 "too."},
                {1, 1'000'000},
                &limits->max_connections);
  typed.Integer({"max_upload_streams",
                 "Upload streams at once, all maps together. 0: one for each 512 KiB of "
                 "queue_bytes_total, and at least 16."},
                {0, 1'000'000},
                &limits->max_upload_streams);
  typed.Integer({"upload_window_frames",
                 "Frames that one upload stream may have under way; below what a robot sends in a "
                 "commit interval it slows down."},
                {1, 10'000},
                &limits->upload_window_frames);
  typed.Integer({"upload_window_bytes",
                 "Bytes that one upload stream may have under way; at least max_message_bytes."},
                {64 * kKiB, 4096 * kMiB},
                &limits->upload_window_bytes);
  typed.Integer({"queue_bytes_per_map", "Bytes of frames that wait for one map's integration."},
                {64 * kKiB, kTiB},
                &limits->queue_bytes_per_map);
  typed.Integer(
      {"queue_bytes_total", "The same for all maps together: the bound on memory under overload."},
      {64 * kKiB, kTiB},
      &limits->queue_bytes_total);
  typed.Integer({"memory_bytes",
                 "Bytes of memory that the daemon may hold; beyond, uploads and new maps are "
                 "refused with MEMORY_LOW. 0: three quarters of what the machine, or the control "
                 "group, has."},
                {0, 1024 * kTiB},
                &limits->memory_bytes);
}

void VisitCommit(CommitOptions* commit, FieldVisitor* visitor) {
  TypedVisitor typed(visitor);
  visitor->Section("commit",
                   "When work becomes visible and durable. Never changes what a map holds.");
  typed.Integer({"max_frames", "A revision is committed after this many frames."},
                {1, 10'000},
                &commit->max_frames);
  typed.Duration(
      {"max_delay_ms", "A revision is committed this long after its first frame at the latest."},
      {1, 60'000},
      &commit->max_delay);
}

void VisitRetention(RetentionOptions* retention, FieldVisitor* visitor) {
  TypedVisitor typed(visitor);
  visitor->Section("retention", "What is kept longer than the present needs it.");
  typed.Duration({"frame_log_age_s",
                  "Integrated frames leave the log after this time, for maps that do not say "
                  "otherwise. 0: at once."},
                 {0, 100 * kYearS},
                 &retention->frame_log_age);
  typed.Integer({"frame_log_bytes",
                 "The oldest integrated frames leave the log when it holds more, for maps that do "
                 "not say otherwise."},
                {0, 1024 * kTiB},
                &retention->frame_log_bytes);
  typed.Duration({"session_idle_s",
                  "Upload sessions are forgotten when idle for this long; a frame that is sent "
                  "again later would count twice."},
                 {7 * kDayS, 100 * kYearS},
                 &retention->session_idle);
  typed.Duration({"trim_interval_s", "How often retention is applied."},
                 {1, kDayS},
                 &retention->trim_interval);
}

void VisitWatch(WatchServiceOptions* watch, FieldVisitor* visitor) {
  TypedVisitor typed(visitor);
  visitor->Section("watch", "Those who watch maps.");
  typed.Integer(
      {"max_watches", "Watches at once, all maps together."}, {1, 1'000'000}, &watch->max_watches);
  typed.Integer(
      {"openings_per_second",
       "Watches that one address may open a second, behind a burst of twice max_watches."},
      {1, 1'000'000},
      &watch->openings_per_second);
  typed.Duration({"stall_timeout_s",
                  "A client that takes nothing of what a watch, an export or a section sends it "
                  "for this long is ended; a watch may resume."},
                 {1, kDayS},
                 &watch->stall_timeout);
}

void VisitStore(StoreOptions* store, FieldVisitor* visitor) {
  TypedVisitor typed(visitor);
  visitor->Section("store", "RocksDB in data_dir, and what it keeps of every map.");
  typed.Integer({"block_cache_bytes", "Bytes of RocksDB's block cache."},
                {kMiB, kTiB},
                &store->block_cache_bytes);
  typed.Integer({"write_buffer_bytes",
                 "Bytes of RocksDB's write buffers. A restart replays up to twice as much."},
                {4 * kMiB, kTiB},
                &store->write_buffer_bytes);
  typed.Integer(
      {"min_free_disk_bytes",
       "Uploads are refused with DISK_LOW when the disk has fewer bytes left; at least three "
       "times write_buffer_bytes."},
      {0, 1024 * kTiB},
      &store->min_free_disk_bytes);
  typed.Integer(
      {"log_segment_bytes", "Bytes of a file of a map's log, about; a trim drops whole files."},
      {64 * kKiB, 4096 * kMiB},
      &store->log_segment_bytes);
  typed.Integer({"kept_poses", "Newest frame poses that are kept when their frames are not."},
                {0, 1'000'000'000'000},
                &store->kept_poses);
  typed.Integer({"kept_events", "Newest events of a map that are kept."},
                {1, 1'000'000'000'000},
                &store->kept_events);
  typed.Duration({"change_list_age_s",
                  "Change lists are dropped after this time: a reader that is further behind "
                  "starts from a snapshot."},
                 {0, 100 * kYearS},
                 &store->change_list_age);
  typed.Integer({"kept_change_lists", "Most change lists that are kept of a map."},
                {1, 100'000'000},
                &store->kept_change_lists);
  typed.Duration({"change_list_grace_s",
                  "Change lists that a live watcher has not seen yet are kept so much longer."},
                 {0, 100 * kYearS},
                 &store->change_list_grace);
}

}  // namespace

void VisitFields(ServerConfig* config, FieldVisitor* visitor) {
  VisitRoot(config, visitor);
  VisitLog(&config->log, visitor);
  VisitLimits(&config->limits, visitor);
  VisitCommit(&config->commit, visitor);
  VisitRetention(&config->retention, visitor);
  VisitWatch(&config->watch, visitor);
  VisitStore(&config->store, visitor);
}

}  // namespace steadymap
