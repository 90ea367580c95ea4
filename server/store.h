#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "core/geometry.h"
#include "core/identifiers.h"
#include "core/map_config.h"
#include "core/map_delta.h"
#include "core/map_snapshot.h"
#include "core/timestamp.h"
#include "server/sequence_set.h"

namespace steadymap {

/// A map as the store knows it: its resource without its content.
struct MapRecord {
  MapKey key;
  MapName name;
  std::string display_name;
  MapConfig config;
  std::chrono::seconds frame_log_age{0};  ///< Retention of integrated frames; 0: drop at once.
  std::uint64_t frame_log_bytes = 0;      ///< Retention of integrated frames; 0: drop at once.
  std::uint64_t byte_budget = 0;          ///< Of the volumes in memory; 0: no limit.
  std::chrono::milliseconds max_commit_delay{0};  ///< 0: as the server is configured.
  Timestamp create_time;
  std::string incarnation;
  std::string request_id;     ///< Of the request that created it; may be empty.
  std::uint64_t version = 1;  ///< Counts changes of this record; the source of its etag.

  /// OK, or `DataLoss` if the record is damaged on disk; then only `name`, and `key` unless 0,
  /// hold. Such a map is quarantined: it can be deleted, nothing else.
  absl::Status condition;
};

/// Names an upload session within a map.
struct SessionName {
  std::string robot;
  std::string session;

  friend auto operator<=>(const SessionName&, const SessionName&) = default;
};

/// What is remembered of an upload session, so that no frame counts twice.
struct SessionRecord {
  SessionName name;
  SequenceSet settled;       ///< Client sequences that are durable or were refused.
  MapSequence last_map_seq;  ///< Of the session's newest durable frame; 0: none.
  Timestamp last_active;     ///< By the server's clock.
};

/// A frame on its way into the log.
struct LogFrame {
  MapSequence sequence;
  std::string robot;
  Timestamp capture_time;
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
  std::string packed_frame;  ///< Serialized `v1::Frame`, as it was uploaded.
};

/// All that becomes durable for one map in one append.
struct LogAppend {
  MapKey map;
  Timestamp append_time;                ///< By the server's clock; retention counts from here.
  std::vector<LogFrame> frames;         ///< Consecutive sequence numbers behind the map's head.
  std::vector<SessionRecord> sessions;  ///< New state of the sessions that sent them.
};

/// Where a frame was taken.
struct FramePose {
  MapSequence sequence;
  std::string robot;
  Timestamp capture_time;
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
};

/// An event with its place in its map's history.
struct StoredEvent {
  EventNumber number;
  ObjectEvent event;

  friend bool operator==(const StoredEvent&, const StoredEvent&) = default;
};

/// Everything a map needs to go on after a restart.
struct StoredState {
  MapSnapshot snapshot;      ///< At the newest committed revision.
  MapSequence durable_head;  ///< Newest frame in the log; 0: none was ever.
  std::vector<SessionRecord> sessions;
};

/// What the commits between two revisions changed: names, not values.
struct ChangeList {
  std::uint64_t commits = 0;
  std::vector<ObjectId> objects{};  ///< By rising id, no id twice; forgotten ones included.
  std::vector<LeafKey> leaves{};    ///< Sorted, no key twice; leaves that are gone included.

  friend bool operator==(const ChangeList&, const ChangeList&) = default;
};

/// What a trim may drop of a map.
struct TrimBounds {
  /// Log frames up to and including this one; it must be integrated.
  MapSequence last;
  Timestamp now;  ///< By the server's clock.
  /// Sessions idle since before this moment.
  Timestamp forget_sessions_before;
  /// The oldest revision that a live watcher is at: change lists behind it have a grace.
  std::optional<Revision> oldest_watched{};
};

struct StoreOptions {
  /// Bytes of RocksDB's block cache.
  std::size_t block_cache_bytes = std::size_t{32} << 20;

  /// Bytes of RocksDB's write buffers, all column families together.
  std::size_t write_buffer_bytes = std::size_t{32} << 20;

  /// Below this many free bytes on the data folder's disk, appends are refused with `DISK_LOW`.
  std::uint64_t min_free_disk_bytes = std::uint64_t{256} << 20;

  /// Newest poses of a map that are kept even when their frames have left the log.
  std::uint64_t kept_poses = 100'000;

  /// Newest events of a map that are kept.
  std::uint64_t kept_events = 1'000'000;

  /// Change lists of a map are dropped when older than this or when there are more than
  /// `kept_change_lists`: a reader that is further behind starts from a snapshot.
  std::chrono::seconds change_list_age{3600};
  std::uint64_t kept_change_lists = 100'000;

  /// Change lists that a live watcher has not seen yet are kept for so much longer.
  std::chrono::seconds change_list_grace{600};
};

/// The durable side of all maps: RocksDB, embedded (service.md section 5).
///
/// Every write below is one atomic batch, synced before it returns. After a failed sync nothing is
/// retried: the error is remembered, every later write fails with `STORE_READ_ONLY`, and `health()`
/// reports it. Values carry a schema version and a checksum; a damaged one gives `DataLoss` with
/// reason `CHECKSUM`, naming its key.
///
/// Thread-safe. Writes of one map take turns; a caller that wants an order has to make it.
class Store {
 public:
  /// Opens the store in `folder`, creating it if need be.
  /// Errors: `FailedPrecondition` if another process holds it, or it was written by a newer schema;
  /// `PermissionDenied`/`NotFound` if the folder cannot be written or made; `DataLoss` if damaged.
  static absl::StatusOr<std::unique_ptr<Store>> Open(const std::filesystem::path& folder,
                                                     const StoreOptions& options);
  virtual ~Store() = default;

  /// Creates a map; `record.key` is ignored and assigned. Errors: `AlreadyExists`.
  virtual absl::StatusOr<MapRecord> CreateMap(const MapRecord& record) = 0;

  /// Replaces the record of an existing map. Errors: `NotFound`.
  virtual absl::Status UpdateMap(const MapRecord& record) = 0;

  /// Deletes a map with everything stored for it, damaged or not. Errors: `NotFound`.
  virtual absl::Status DeleteMap(MapKey map) = 0;

  /// All maps in the order of their names. A damaged record is no error: see `condition`.
  virtual absl::StatusOr<std::vector<MapRecord>> ListMaps() = 0;

  /// Reads a map's committed state. Cost: up to 20 us a leaf on a busy machine.
  virtual absl::StatusOr<StoredState> LoadMap(const MapRecord& record) = 0;

  /// Makes frames durable, for several maps at once: their log entries, poses, sessions and heads.
  /// An append without frames stores its sessions. All or nothing.
  /// Errors: `ResourceExhausted` with reason `DISK_LOW`; `Unavailable` with `STORE_READ_ONLY`;
  /// `NotFound` for an unknown map; `FailedPrecondition` if the frames do not follow the head or a
  /// map appears twice.
  virtual absl::Status AppendFrames(const std::vector<LogAppend>& appends) = 0;

  /// Makes a commit durable: its objects, leaves, free space and robots, its events, numbered on
  /// from the last one, its change list and the revision. `now` is the server's clock. A delta with
  /// `to == from` changes nothing. Errors: `NotFound`; `FailedPrecondition` if `delta.from` is not
  /// the stored revision or `delta.to` lies beyond the log's head; `Unavailable` with
  /// `STORE_READ_ONLY`.
  virtual absl::Status CommitRevision(MapKey map, const MapDelta& delta, Timestamp now) = 0;

  /// Calls `visit` for the frames of the log with `first` <= sequence, in order, until it returns
  /// an error, which is returned. Frames below the retained part are left out; frames that are
  /// appended meanwhile may be.
  /// Errors: `DataLoss` for a damaged or missing frame.
  virtual absl::Status ReadLog(MapKey map,
                               MapSequence first,
                               const std::function<absl::Status(LogFrame)>& visit) = 0;

  /// At most `limit` poses of frames with `first` <= sequence <= `last`, in order.
  virtual absl::StatusOr<std::vector<FramePose>> ReadPoses(MapKey map,
                                                           MapSequence first,
                                                           MapSequence last,
                                                           std::size_t limit) = 0;

  /// At most `limit` events of the map with `first` <= number, in order. Older ones than
  /// `StoreOptions::kept_events` may be gone.
  virtual absl::StatusOr<std::vector<StoredEvent>> ReadEvents(MapKey map,
                                                              EventNumber first,
                                                              std::size_t limit) = 0;

  /// What the commits behind `from` up to `to` changed. Both must be revisions that were committed,
  /// or 0, `from` not above `to`.
  /// Errors: `OutOfRange` with reason `REVISION_COMPACTED` if one of the lists is gone, or there
  /// were no such commits.
  virtual absl::StatusOr<ChangeList> ReadChanges(MapKey map, Revision from, Revision to) = 0;

  /// Drops log frames within `bounds` that retention no longer wants, change lists, events and
  /// poses beyond what `StoreOptions` keeps, and idle sessions. What lies beyond the stored
  /// revision is never dropped. Cost: some milliseconds, with disk space to give back some 100: not
  /// for a thread that robots wait for.
  virtual absl::Status Trim(const MapRecord& map, const TrimBounds& bounds) = 0;

  /// OK, or the error that made the store read-only.
  virtual absl::Status health() const = 0;
};

}  // namespace steadymap
