#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "core/geometry/geometry.h"
#include "core/map/map_delta.h"
#include "core/map/map_snapshot.h"
#include "core/types/identifiers.h"
#include "core/types/map_config.h"
#include "core/types/timestamp.h"
#include "server/store/model/integration_note.h"
#include "server/store/model/sequence_set.h"

namespace steadymap {

/// The total time for which a map has been open, summed over all runs of the server. It never
/// decreases and never jumps, whatever happens to the system clock. Retention and the expiry of
/// upload sessions are measured in it.
using MapUptime = std::chrono::nanoseconds;

/// The position and heading of a world frame on the Earth, WGS 84.
struct GeoAnchor {
  double latitude_deg = 0.0;
  double longitude_deg = 0.0;
  double altitude_m = 0.0;   ///< Height above the ellipsoid.
  double heading_deg = 0.0;  ///< Direction of the x axis, clockwise from true north.

  friend bool operator==(const GeoAnchor&, const GeoAnchor&) = default;
};

/// The meaning of a map's coordinates, for its users.
struct WorldFrame {
  std::string description;
  std::string floor;
  std::optional<GeoAnchor> anchor;

  friend bool operator==(const WorldFrame&, const WorldFrame&) = default;
};

/// The stored description of a map: its resource fields without its content.
struct MapRecord {
  MapKey key;
  MapName name;
  std::string display_name;
  MapConfig config;
  /// Largest age of integrated frames in the log; 0: dropped at once.
  std::chrono::seconds frame_log_age{0};
  /// Largest size of integrated frames in the log; 0: dropped at once.
  std::uint64_t frame_log_bytes = 0;
  std::uint64_t byte_budget = 0;                  ///< Memory budget of the map; 0: no limit.
  std::chrono::milliseconds max_commit_delay{0};  ///< 0: the server's configured delay.
  Timestamp create_time;
  std::string incarnation;
  std::map<std::string, std::string> labels;
  WorldFrame world_frame;
  std::string request_id;         ///< ID of the request that created the map; may be empty.
  std::string change_request_id;  ///< ID of the last request that changed it; may be empty.
  std::uint64_t version = 1;      ///< Number of changes of this record; the source of its etag.

  /// OK, or `DataLoss` if the record is damaged on disk. Then only `key` and `name` are valid;
  /// `name` is `lost/map-KEY` where no name could be read. Such a map is quarantined: deletion is
  /// the only operation allowed on it.
  absl::Status condition;
};

/// Identifies an upload session within a map.
struct SessionName {
  SensorName sensor;
  std::string session;

  friend auto operator<=>(const SessionName&, const SessionName&) = default;
};

/// The stored state of an upload session. It makes uploads idempotent: no frame is integrated
/// twice.
struct SessionRecord {
  SessionName name;
  SequenceSet settled;         ///< Client sequences of frames that are durable or were refused.
  MapSequence last_map_seq;    ///< Sequence of the session's newest durable frame; 0: none.
  MapUptime last_active{0};    ///< Map uptime at the session's last message.
  Timestamp last_active_time;  ///< Server clock at the session's last message, for display.
  bool is_over = false;        ///< True if no frame follows the session's end in the log.
};

/// The kind of an entry of a map's log.
enum class LogEntryKind {
  kFrame,       ///< A frame uploaded by a robot.
  kClasses,     ///< Classes added to the map's class table.
  kSkipped,     ///< No content: a salvage writes it in place of an entry that is lost or excluded.
  kSessionEnd,  ///< The session of a robot has ended.
};

/// An entry of a map's log. Every change of a map is an entry, so the log alone determines the map.
struct LogEntry {
  MapSequence sequence;
  LogEntryKind kind = LogEntryKind::kFrame;
  SensorName source;                     ///< `kFrame`, `kSessionEnd`: the sensor.
  std::string packed_frame;              ///< `kFrame` only: the `v1::Frame` as it was uploaded.
  std::vector<SemanticClass> classes{};  ///< `kClasses` only: the added classes.
};

/// The entries and sessions of a map that one append makes durable.
struct LogAppend {
  MapKey map;
  MapUptime uptime{0};  ///< Map uptime at the append; the age of the entries is measured from it.
  std::vector<LogEntry> entries;        ///< Consecutive sequence numbers after the log's head.
  std::vector<SessionRecord> sessions;  ///< New state of the sessions that sent the entries.
};

/// The camera pose of a frame at its capture.
struct FramePose {
  MapSequence sequence;
  SensorName source;
  Timestamp capture_time;
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
};

/// An event and its number in the history of its map.
struct StoredEvent {
  EventNumber number;
  ObjectEvent event;

  friend bool operator==(const StoredEvent&, const StoredEvent&) = default;
};

/// Identifies a commit in the history of a map. `hash` depends on all commits up to this one: if
/// two copies of a map diverge, their hashes differ even where their revisions are equal.
struct CommitMark {
  Revision revision;
  std::uint64_t hash = 0;

  friend bool operator==(const CommitMark&, const CommitMark&) = default;
};

/// The data that a commit makes durable in addition to the map's change.
struct CommitDetails {
  /// Poses of the frames integrated since the previous commit, in order.
  std::vector<FramePose> poses{};
  /// Map uptime at the commit; the age of its change list is measured from it.
  MapUptime uptime{0};
};

/// The state of a map that is needed to continue after a restart.
struct StoredState {
  MapSnapshot snapshot;  ///< The map at the newest committed revision.
  CommitMark commit;     ///< The newest commit.
  /// Sequence of the newest durable entry; 0: no entry was ever appended.
  MapSequence durable_head;
  /// The class table at `durable_head`: the classes of the snapshot and those added by newer
  /// entries of the log.
  std::vector<SemanticClass> durable_classes;
  std::vector<SessionRecord> sessions;
  MapUptime uptime{0};  ///< At least the map uptime at the last write.
  /// Records the entry that is being integrated, in case its integration ends the process.
  std::shared_ptr<IntegrationNote> note;
};

/// The identifiers, without values, of the objects and leaves changed between two revisions.
struct ChangeList {
  std::uint64_t commits = 0;
  std::vector<ObjectId> objects{};  ///< Ascending, without duplicates; includes deleted objects.
  std::vector<LeafKey> leaves{};    ///< Sorted, without duplicates; includes deleted leaves.

  friend bool operator==(const ChangeList&, const ChangeList&) = default;
};

/// The limits of one trim of a map.
struct TrimBounds {
  MapUptime uptime{0};  ///< Current uptime of the map.
  /// Sessions that were last active before this uptime are deleted, except those in
  /// `sessions_in_use`.
  MapUptime forget_sessions_before{0};
  std::set<SessionName> sessions_in_use{};
  /// The oldest revision held by a live watcher. Newer change lists get `change_list_grace`.
  std::optional<Revision> oldest_watched{};
  /// Disk space is low: all integrated entries are dropped from the log, whatever the map's
  /// retention.
  bool disk_is_low = false;
};

struct StoreOptions {
  /// Size of RocksDB's block cache in bytes, for all maps together.
  std::size_t block_cache_bytes = std::size_t{32} << 20;

  /// Size of RocksDB's write buffers in bytes, for all maps together.
  std::size_t write_buffer_bytes = std::size_t{32} << 20;

  /// Appends are refused with `DISK_LOW` while the data folder's disk has fewer free bytes than
  /// this. At least three times `write_buffer_bytes`, because the buffered records must still be
  /// written.
  std::uint64_t min_free_disk_bytes = std::uint64_t{256} << 20;

  /// Approximate size of one file of a map's entry log, in bytes. A trim drops whole files.
  std::uint64_t log_segment_bytes = std::uint64_t{16} << 20;

  /// Number of newest poses kept for each map, even after their frames were dropped from the log.
  std::uint64_t kept_poses = 100'000;

  /// Number of newest events kept for each map.
  std::uint64_t kept_events = 1'000'000;

  /// A change list is dropped when it is older than this, or when the map has more than
  /// `kept_change_lists`. A reader that is further behind starts from a snapshot.
  std::chrono::seconds change_list_age{3600};
  std::uint64_t kept_change_lists = 100'000;

  /// Additional time for which change lists are kept while a live watcher has not received them.
  std::chrono::seconds change_list_grace{600};
};

/// The durable storage of all maps: a data folder with one folder for each map. Each map has its
/// own entry log, in which frames become durable, and its own RocksDB, which contains the
/// integrated map. Damage to the files of one map therefore affects that map alone.
///
/// Every write below is atomic, and synced before it returns. After a write that failed for any
/// reason except a full disk, every later write to that map fails with `STORE_READ_ONLY`, and
/// `health()` of the map reports the cause, until `LoadMap` reopens the map. Values carry a schema
/// version and a checksum. A damaged value gives `DataLoss` with reason `CHECKSUM` and its location
/// in the message.
///
/// Thread-safe. At most one thread at a time may append to a map, and at most one may commit to it.
class Store {
 public:
  /// Opens the store in `folder`, and creates it if it does not exist. `LoadMap` opens the maps.
  /// Errors: `FailedPrecondition` if another process holds the folder, or if it was written with a
  /// newer schema; `PermissionDenied`/`NotFound` if the folder cannot be written or created;
  /// `DataLoss` if it is damaged.
  static absl::StatusOr<std::unique_ptr<Store>> Open(const std::filesystem::path& folder,
                                                     const StoreOptions& options);
  virtual ~Store() = default;

  /// Creates a map. Ignores `record.key` and assigns a new key. Errors: `AlreadyExists`;
  /// `ResourceExhausted` with reason `DISK_LOW`.
  virtual absl::StatusOr<MapRecord> CreateMap(const MapRecord& record) = 0;

  /// Replaces the record of an existing map. Errors: `NotFound`; `FailedPrecondition` if the name
  /// or the config differs; `DataLoss` for a quarantined map.
  virtual absl::Status UpdateMap(const MapRecord& record) = 0;

  /// Deletes a map and all of its stored data, damaged or not. The name can be reused at once.
  /// Calls for the map that are in progress in other threads fail with `NotFound` or have no
  /// effect. Errors: `NotFound`.
  virtual absl::Status DeleteMap(MapKey map) = 0;

  /// Returns all maps, ordered by name. A damaged record is not an error: see `condition`.
  virtual absl::StatusOr<std::vector<MapRecord>> ListMaps() = 0;

  /// Opens a map if it is not open, or if a write to it has failed, and reads its committed state.
  /// If the disk has too little free space, the map is opened read-only: see `health`. Cost: up to
  /// 20 us per leaf on a busy machine.
  virtual absl::StatusOr<StoredState> LoadMap(const MapRecord& record) = 0;

  /// Makes entries durable, together with the sessions that sent them. An append without entries
  /// stores its sessions. An append is applied as a whole or not at all. Errors:
  /// `ResourceExhausted` with reason `DISK_LOW`; `Unavailable` with reason `STORE_READ_ONLY`;
  /// `NotFound` for a map that does not exist or is not open; `FailedPrecondition` if the entries
  /// do not follow the head.
  virtual absl::Status Append(const LogAppend& append) = 0;

  /// Makes a commit durable: objects, leaves, free space and robots, its events (numbered
  /// consecutively after the previous event), its poses, its change list and its revision. A delta
  /// with `to == from` changes nothing. Returns the mark of the commit. Errors: `NotFound`;
  /// `FailedPrecondition` if `delta.from` is not the stored revision or `delta.to` is greater than
  /// the log's head; `ResourceExhausted` with reason `DISK_LOW`, after which the caller retries;
  /// `Unavailable` with reason `STORE_READ_ONLY`.
  virtual absl::StatusOr<CommitMark> CommitRevision(MapKey map,
                                                    const MapDelta& delta,
                                                    const CommitDetails& details) = 0;

  /// Calls `visit` for the entries of the log with sequence >= `first`, in order, until it returns
  /// an error, which is returned. Entries that retention has dropped are skipped. Entries appended
  /// during the call may be skipped. Errors: `DataLoss` for a damaged or missing entry.
  virtual absl::Status ReadLog(MapKey map,
                               MapSequence first,
                               const std::function<absl::Status(LogEntry)>& visit) = 0;

  /// Returns at most `limit` poses of integrated frames with `first` <= sequence <= `last`, in
  /// order.
  virtual absl::StatusOr<std::vector<FramePose>> ReadPoses(MapKey map,
                                                           MapSequence first,
                                                           MapSequence last,
                                                           std::size_t limit) = 0;

  /// Returns at most `limit` events of the map with number >= `first`, in order. Events beyond the
  /// newest `StoreOptions::kept_events` may be missing.
  virtual absl::StatusOr<std::vector<StoredEvent>> ReadEvents(MapKey map,
                                                              EventNumber first,
                                                              std::size_t limit) = 0;

  /// Returns the changes of the commits after `from`, up to and including `to`. `from` must not be
  /// greater than `to`. Errors: `OutOfRange` with reason `REVISION_COMPACTED` if a change list was
  /// dropped, if such commits do not exist, or if `from` belongs to another history than this
  /// map's.
  virtual absl::StatusOr<ChangeList> ReadChanges(MapKey map, CommitMark from, Revision to) = 0;

  /// Drops log files, change lists, events, poses and idle sessions beyond their retention, and
  /// stores the uptime. Log entries after the stored revision are never dropped. Cost: some
  /// milliseconds, so never called on the upload path.
  virtual absl::Status Trim(const MapRecord& map, const TrimBounds& bounds) = 0;

  /// Removes the files of deleted maps that are no longer in use. `Trim` does this as well.
  virtual void Reclaim() {}

  /// Returns OK if the map accepts writes. Otherwise returns the error of the earlier failed write,
  /// `DISK_LOW` for a map that was opened read-only, or `NotFound` for a map that does not exist or
  /// is not open.
  virtual absl::Status health(MapKey map) const = 0;

  /// Returns OK, or `ResourceExhausted` with reason `DISK_LOW` if an append would be refused now.
  virtual absl::Status CheckDisk() const = 0;

  /// True if a thread is blocked in a write until the disk has free space.
  virtual bool IsWaitingForDisk() const { return false; }

  /// Makes writes that are blocked by a full disk fail, now and later. Called before the process
  /// ends.
  virtual void StopWaitingForDisk() {}
};

}  // namespace steadymap
