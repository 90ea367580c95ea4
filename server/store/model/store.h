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

/// How long a map has been open, summed over all runs of the server. It never falls and never
/// jumps, whatever the machine's clock does: retention, and the memory of upload sessions, count in
/// it.
using MapUptime = std::chrono::nanoseconds;

/// Where a world frame is on the Earth, WGS 84.
struct GeoAnchor {
  double latitude_deg = 0.0;
  double longitude_deg = 0.0;
  double altitude_m = 0.0;   ///< Above the ellipsoid.
  double heading_deg = 0.0;  ///< Of x, clockwise from true north.

  friend bool operator==(const GeoAnchor&, const GeoAnchor&) = default;
};

/// What a map's coordinates mean, for its users.
struct WorldFrame {
  std::string description;
  std::string floor;
  std::optional<GeoAnchor> anchor;

  friend bool operator==(const WorldFrame&, const WorldFrame&) = default;
};

/// A map as the store knows it: its resource without its content.
struct MapRecord {
  MapKey key;
  MapName name;
  std::string display_name;
  MapConfig config;
  std::chrono::seconds frame_log_age{0};  ///< Retention of integrated frames; 0: drop at once.
  std::uint64_t frame_log_bytes = 0;      ///< Retention of integrated frames; 0: drop at once.
  std::uint64_t byte_budget = 0;          ///< Of the map in memory; 0: no limit.
  std::chrono::milliseconds max_commit_delay{0};  ///< 0: as the server is configured.
  Timestamp create_time;
  std::string incarnation;
  std::map<std::string, std::string> labels;
  WorldFrame world_frame;
  std::string request_id;         ///< Of the request that created it; may be empty.
  std::string change_request_id;  ///< Of the last one that changed it; may be empty.
  std::uint64_t version = 1;      ///< Counts changes of this record; the source of its etag.

  /// OK, or `DataLoss` if the record is damaged on disk; then only `key` holds, and `name` where it
  /// could be read. Such a map is quarantined: it can be deleted, nothing else.
  absl::Status condition;
};

/// Names an upload session within a map.
struct SessionName {
  SensorName sensor;
  std::string session;

  friend auto operator<=>(const SessionName&, const SessionName&) = default;
};

/// What is remembered of an upload session, so that no frame counts twice.
struct SessionRecord {
  SessionName name;
  SequenceSet settled;         ///< Client sequences that are durable or were refused.
  MapSequence last_map_seq;    ///< Of the session's newest durable frame; 0: none.
  MapUptime last_active{0};    ///< When it last sent something.
  Timestamp last_active_time;  ///< The same by the server's clock, for people.
};

/// What an entry of a map's log is.
enum class LogEntryKind {
  kFrame,    ///< A frame that a robot uploaded.
  kClasses,  ///< Classes that the map's table gains.
  kSkipped,  ///< Nothing: a salvage put it in place of an entry that is lost or passed over.
};

/// An entry of a map's log. Everything that changes a map is one, so that the log alone makes the
/// map.
struct LogEntry {
  MapSequence sequence;
  LogEntryKind kind = LogEntryKind::kFrame;
  SensorName source;                     ///< Of a frame: what took it.
  std::string packed_frame;              ///< Of a frame: the `v1::Frame` as it was uploaded.
  std::vector<SemanticClass> classes{};  ///< Of `kClasses`.
};

/// All that becomes durable for a map in one append.
struct LogAppend {
  MapKey map;
  MapUptime uptime{0};                  ///< Retention counts from here.
  std::vector<LogEntry> entries;        ///< Consecutive sequence numbers behind the log's head.
  std::vector<SessionRecord> sessions;  ///< New state of the sessions that sent them.
};

/// Where a frame was taken.
struct FramePose {
  MapSequence sequence;
  SensorName source;
  Timestamp capture_time;
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
};

/// An event with its place in its map's history.
struct StoredEvent {
  EventNumber number;
  ObjectEvent event;

  friend bool operator==(const StoredEvent&, const StoredEvent&) = default;
};

/// A commit in the history of a map. `hash` depends on all commits up to this one: two copies of a
/// map that went different ways since they were one differ in it, though their revisions are equal.
struct CommitMark {
  Revision revision;
  std::uint64_t hash = 0;

  friend bool operator==(const CommitMark&, const CommitMark&) = default;
};

/// What a commit makes durable besides the map's change.
struct CommitDetails {
  std::vector<FramePose> poses{};  ///< Of the frames since the commit before, in their order.
  MapUptime uptime{0};             ///< Retention of change lists counts from here.
};

/// Everything a map needs to go on after a restart.
struct StoredState {
  MapSnapshot snapshot;      ///< At the newest committed revision.
  CommitMark commit;         ///< The newest commit.
  MapSequence durable_head;  ///< Newest entry in the log; 0: none was ever.
  /// The class table at `durable_head`: the snapshot's, and what the log adds to it.
  std::vector<SemanticClass> durable_classes;
  std::vector<SessionRecord> sessions;
  MapUptime uptime{0};  ///< As far as it is known: at least up to the last write.
  /// Remembers which entry is being integrated, for the case that it ends the process.
  std::shared_ptr<IntegrationNote> note;
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
  MapUptime uptime{0};  ///< Now.
  /// Sessions idle since before this moment are forgotten, but for those that are in use.
  MapUptime forget_sessions_before{0};
  std::set<SessionName> sessions_in_use{};
  /// The oldest revision that a live watcher is at: change lists behind it have a grace.
  std::optional<Revision> oldest_watched{};
  /// The disk is low: drops the log of all that is integrated, whatever retention wants.
  bool disk_is_low = false;
};

struct StoreOptions {
  /// Bytes of RocksDB's block cache, all maps together.
  std::size_t block_cache_bytes = std::size_t{32} << 20;

  /// Bytes of RocksDB's write buffers, all maps together.
  std::size_t write_buffer_bytes = std::size_t{32} << 20;

  /// Below this many free bytes on the data folder's disk, appends are refused with `DISK_LOW`. At
  /// least three times `write_buffer_bytes`: what is in the buffers has to find room.
  std::uint64_t min_free_disk_bytes = std::uint64_t{256} << 20;

  /// A file of a map's entry log takes about so many bytes; a trim drops whole files.
  std::uint64_t log_segment_bytes = std::uint64_t{16} << 20;

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

/// The durable side of all maps (service.md section 5): a folder with a folder a map. Each map has
/// a log of its own, in which frames become durable, and a RocksDB of its own, which holds what was
/// made of them: damage to one map's files harms that map alone.
///
/// Every write below is atomic, and synced before it returns. After a write that failed for another
/// reason than a full disk, every later write to that map fails with `STORE_READ_ONLY`, and
/// `health()` of the map says why, until `LoadMap` opens it anew. Values carry a schema version and
/// a checksum; a damaged one gives `DataLoss` with reason `CHECKSUM`, naming its place.
///
/// Thread-safe. Appends to one map are for one thread at a time, and so are commits.
class Store {
 public:
  /// Opens the store in `folder`, creating it if need be. Maps are opened by `LoadMap`.
  /// Errors: `FailedPrecondition` if another process holds it, or it was written by a newer schema;
  /// `PermissionDenied`/`NotFound` if the folder cannot be written or made; `DataLoss` if damaged.
  static absl::StatusOr<std::unique_ptr<Store>> Open(const std::filesystem::path& folder,
                                                     const StoreOptions& options);
  virtual ~Store() = default;

  /// Creates a map; `record.key` is ignored and assigned. Errors: `AlreadyExists`;
  /// `ResourceExhausted` with reason `DISK_LOW`.
  virtual absl::StatusOr<MapRecord> CreateMap(const MapRecord& record) = 0;

  /// Replaces the record of an existing map. Errors: `NotFound`.
  virtual absl::Status UpdateMap(const MapRecord& record) = 0;

  /// Deletes a map with everything stored for it, damaged or not; its name may be used again at
  /// once. What is under way for the map in other threads fails with `NotFound` or comes to
  /// nothing. Errors: `NotFound`.
  virtual absl::Status DeleteMap(MapKey map) = 0;

  /// All maps in the order of their names. A damaged record is no error: see `condition`.
  virtual absl::StatusOr<std::vector<MapRecord>> ListMaps() = 0;

  /// Opens a map if it is not open, or if a write to it has failed, and reads its committed state.
  /// On a disk without room it is opened for reading alone: see `health`.
  /// Cost: up to 20 us a leaf on a busy machine.
  virtual absl::StatusOr<StoredState> LoadMap(const MapRecord& record) = 0;

  /// Makes entries durable, with the sessions that sent them. An append without entries stores its
  /// sessions. All or nothing. Errors: `ResourceExhausted` with reason `DISK_LOW`; `Unavailable`
  /// with `STORE_READ_ONLY`; `NotFound` for a map that is unknown or not open; `FailedPrecondition`
  /// if the entries do not follow the head.
  virtual absl::Status Append(const LogAppend& append) = 0;

  /// Makes a commit durable: objects, leaves, free space and robots, its events, numbered on from
  /// the last one, poses, its change list and the revision. A delta with `to == from` changes
  /// nothing. Returns the commit's mark. Errors: `NotFound`; `FailedPrecondition` if `delta.from`
  /// is not the stored revision or `delta.to` lies beyond the log's head; `ResourceExhausted` with
  /// reason `DISK_LOW`: to be tried again; `Unavailable` with `STORE_READ_ONLY`.
  virtual absl::StatusOr<CommitMark> CommitRevision(MapKey map,
                                                    const MapDelta& delta,
                                                    const CommitDetails& details) = 0;

  /// Calls `visit` for the entries of the log with `first` <= sequence, in order, until it returns
  /// an error, which is returned. Entries below the retained part are left out; entries that are
  /// appended meanwhile may be. Errors: `DataLoss` for a damaged or missing entry.
  virtual absl::Status ReadLog(MapKey map,
                               MapSequence first,
                               const std::function<absl::Status(LogEntry)>& visit) = 0;

  /// At most `limit` poses of integrated frames with `first` <= sequence <= `last`, in order.
  virtual absl::StatusOr<std::vector<FramePose>> ReadPoses(MapKey map,
                                                           MapSequence first,
                                                           MapSequence last,
                                                           std::size_t limit) = 0;

  /// At most `limit` events of the map with `first` <= number, in order. Older ones than
  /// `StoreOptions::kept_events` may be gone.
  virtual absl::StatusOr<std::vector<StoredEvent>> ReadEvents(MapKey map,
                                                              EventNumber first,
                                                              std::size_t limit) = 0;

  /// What the commits behind `from` up to `to` changed, `from` not above `to`.
  /// Errors: `OutOfRange` with reason `REVISION_COMPACTED` if one of the lists is gone, or there
  /// were no such commits, or `from` is a commit of another history than this map's.
  virtual absl::StatusOr<ChangeList> ReadChanges(MapKey map, CommitMark from, Revision to) = 0;

  /// Drops log files that retention no longer wants, change lists, events and poses beyond what
  /// `StoreOptions` keeps, and idle sessions, and notes the uptime. What lies beyond the stored
  /// revision is never dropped. Cost: some milliseconds: not for a thread that robots wait for.
  virtual absl::Status Trim(const MapRecord& map, const TrimBounds& bounds) = 0;

  /// Gives back the space of deleted maps that nobody uses any more; `Trim` does so, too.
  virtual void Reclaim() {}

  /// OK, or why nothing can be written to the map: the error of an earlier write, or `DISK_LOW` for
  /// a map that was opened for reading alone. `NotFound` for a map that is unknown or not open.
  virtual absl::Status health(MapKey map) const = 0;

  /// OK, or `ResourceExhausted` with reason `DISK_LOW` if appends would be refused now.
  virtual absl::Status CheckDisk() const = 0;

  /// Whether a thread waits in a write until the disk has room.
  virtual bool IsWaitingForDisk() const { return false; }

  /// Lets such writes fail from now on: the process is about to end.
  virtual void StopWaitingForDisk() {}
};

}  // namespace steadymap
