#include "tests/support/memory_store.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <deque>
#include <iterator>
#include <set>
#include <string>
#include <utility>

#include "core/error.h"
#include "core/tsdf_codec.h"

namespace steadymap {
namespace {

absl::Status NotThere() {
  return MakeError(absl::StatusCode::kNotFound, reason::kNotFound, "no such map");
}

absl::Status Compacted() {
  return MakeError(
      absl::StatusCode::kOutOfRange, reason::kRevisionCompacted, "what changed is forgotten");
}

}  // namespace

/// One map, as the disk would hold it.
struct MemoryStore::StoredMap {
  /// A frame's pose and what retention asks about it.
  struct StoredPose {
    FramePose pose;
    Timestamp append_time;
    std::uint64_t packed_bytes = 0;
  };

  /// What a commit changed, and what retention asks about it.
  struct StoredCommit {
    Revision from;
    Revision to;
    Timestamp time;
    std::vector<ObjectId> objects;
    std::vector<LeafKey> leaves;
  };

  absl::Status Check(const LogAppend& append) const;
  void Append(const LogAppend& append);
  void TrimLog(MapSequence last, Timestamp now, const MapRecord& retention);
  void TrimCommits(const StoreOptions& options, const TrimBounds& bounds);

  MapRecord record;
  bool damaged = false;
  MapSequence head;
  Timestamp newest_append;
  MapSnapshot snapshot;
  EventNumber last_event;
  std::vector<StoredEvent> events;
  std::deque<StoredCommit> commits;
  std::map<MapSequence, std::string> log;
  std::map<MapSequence, StoredPose> poses;
  std::map<SessionName, SessionRecord> sessions;
};

absl::Status MemoryStore::StoredMap::Check(const LogAppend& append) const {
  MapSequence last = head;
  for (const LogFrame& frame : append.frames) {
    if (frame.sequence != last.Next()) return absl::FailedPreconditionError("a gap in the log");
    last = frame.sequence;
  }
  for (const SessionRecord& session : append.sessions) {
    if (!IsValidId(session.name.robot) || !IsValidId(session.name.session)) {
      return InvalidField(reason::kBadName, "session", "no valid id");
    }
  }
  return absl::OkStatus();
}

void MemoryStore::StoredMap::Append(const LogAppend& append) {
  if (!append.frames.empty()) newest_append = std::max(newest_append, append.append_time);
  for (const LogFrame& frame : append.frames) {
    head = frame.sequence;
    log[frame.sequence] = frame.packed_frame;
    poses[frame.sequence] = {
        {frame.sequence, frame.robot, frame.capture_time, frame.T_world_camera},
        newest_append,
        frame.packed_frame.size()};
  }
  for (const SessionRecord& session : append.sessions) sessions[session.name] = session;
}

void MemoryStore::StoredMap::TrimLog(MapSequence last, Timestamp now, const MapRecord& retention) {
  std::uint64_t bytes = 0;
  bool wanted = true;
  for (auto frame = log.rbegin(); frame != log.rend();) {
    const StoredPose& pose = poses.at(frame->first);
    bytes += pose.packed_bytes;
    const std::chrono::nanoseconds age(now.nanoseconds() - pose.append_time.nanoseconds());
    wanted = wanted && bytes <= retention.frame_log_bytes && age < retention.frame_log_age;
    if (wanted || frame->first > last) {
      ++frame;
    } else {
      frame = std::make_reverse_iterator(log.erase(std::next(frame).base()));
    }
  }
}

void MemoryStore::StoredMap::TrimCommits(const StoreOptions& options, const TrimBounds& bounds) {
  const auto is_older = [&](const StoredCommit& commit, std::chrono::seconds age) {
    return std::chrono::nanoseconds(bounds.now.nanoseconds() - commit.time.nanoseconds()) >= age;
  };
  while (!commits.empty()) {
    const StoredCommit& oldest = commits.front();
    const bool wanted =
        commits.size() <= options.kept_change_lists && !is_older(oldest, options.change_list_age);
    const bool watched = bounds.oldest_watched && oldest.to > *bounds.oldest_watched &&
                         !is_older(oldest, options.change_list_age + options.change_list_grace);
    if (wanted || watched) return;
    commits.pop_front();
  }
}

struct MemoryStore::Content {
  StoreOptions options;
  mutable absl::Mutex mutex;
  std::map<MapKey, StoredMap> maps ABSL_GUARDED_BY(mutex);
  MapKey next_key ABSL_GUARDED_BY(mutex){1};
  absl::Status health ABSL_GUARDED_BY(mutex);
  bool fail_append ABSL_GUARDED_BY(mutex) = false;
  bool fail_commit ABSL_GUARDED_BY(mutex) = false;
  bool disk_low ABSL_GUARDED_BY(mutex) = false;
  std::function<bool()> is_low_for_append ABSL_GUARDED_BY(mutex);
  std::function<void()> write_hook ABSL_GUARDED_BY(mutex);

  absl::Status CheckDisk() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex) {
    if (!disk_low && !(is_low_for_append && is_low_for_append())) return absl::OkStatus();
    return MakeError(absl::StatusCode::kResourceExhausted, reason::kDiskLow, "the disk is full");
  }

  /// Fails for good if `*fault` is set, as a sync that failed.
  absl::Status CheckWrite(bool* fault) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex) {
    if (std::exchange(*fault, false)) {
      health = MakeError(absl::StatusCode::kUnavailable,
                         reason::kStoreReadOnly,
                         "a sync failed as the test asked");
    }
    return health;
  }

  void RunHook() ABSL_LOCKS_EXCLUDED(mutex) {
    std::function<void()> hook;
    {
      const absl::MutexLock lock(&mutex);
      hook = write_hook;
    }
    if (hook) hook();
  }

  bool HasName(const MapName& name) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex) {
    return std::any_of(maps.begin(), maps.end(), [&](const auto& entry) {
      return entry.second.record.name == name;
    });
  }
};

MemoryStore::MemoryStore(const StoreOptions& options) : content_(std::make_shared<Content>()) {
  content_->options = options;
}

MemoryStore::MemoryStore(std::shared_ptr<Content> content) : content_(std::move(content)) {}

MemoryStore::~MemoryStore() = default;

std::unique_ptr<MemoryStore> MemoryStore::Share() const {
  return std::unique_ptr<MemoryStore>(new MemoryStore(content_));
}

void MemoryStore::FailNextAppend() {
  const absl::MutexLock lock(&content_->mutex);
  content_->fail_append = true;
}

void MemoryStore::FailNextCommit() {
  const absl::MutexLock lock(&content_->mutex);
  content_->fail_commit = true;
}

void MemoryStore::Repair() {
  const absl::MutexLock lock(&content_->mutex);
  content_->health = absl::OkStatus();
}

void MemoryStore::SetDiskLow(bool low) {
  const absl::MutexLock lock(&content_->mutex);
  content_->disk_low = low;
}

void MemoryStore::SetDiskLowFor(std::function<bool()> is_low) {
  const absl::MutexLock lock(&content_->mutex);
  content_->is_low_for_append = std::move(is_low);
}

void MemoryStore::DamageMap(MapKey map) {
  const absl::MutexLock lock(&content_->mutex);
  content_->maps.at(map).damaged = true;
}

void MemoryStore::SetWriteHook(std::function<void()> hook) {
  const absl::MutexLock lock(&content_->mutex);
  content_->write_hook = std::move(hook);
}

std::size_t MemoryStore::log_size(MapKey map) const {
  const absl::MutexLock lock(&content_->mutex);
  return content_->maps.at(map).log.size();
}

absl::StatusOr<MapRecord> MemoryStore::CreateMap(const MapRecord& record) {
  if (!IsValidId(record.name.tenant) || !IsValidId(record.name.map)) {
    return InvalidField(reason::kBadName, "name", "no valid ids");
  }
  const absl::MutexLock lock(&content_->mutex);
  if (absl::Status status = content_->CheckDisk(); !status.ok()) return status;
  if (content_->HasName(record.name)) {
    return MakeError(absl::StatusCode::kAlreadyExists, reason::kAlreadyExists, "exists already");
  }
  if (!content_->health.ok()) return content_->health;
  StoredMap map;
  map.record = record;
  map.record.key = content_->next_key;
  map.snapshot = MapSnapshot({record.config.voxel_size_m, record.config.truncation_m});
  map.record.condition = absl::OkStatus();
  content_->next_key = content_->next_key.Next();
  return content_->maps.emplace(map.record.key, map).first->second.record;
}

absl::Status MemoryStore::UpdateMap(const MapRecord& record) {
  const absl::MutexLock lock(&content_->mutex);
  const auto map = content_->maps.find(record.key);
  if (map == content_->maps.end()) return NotThere();
  const MapRecord& old = map->second.record;
  if (old.name != record.name || old.config != record.config) {
    return absl::FailedPreconditionError("the name and the config of a map never change");
  }
  if (!content_->health.ok()) return content_->health;
  map->second.record = record;
  return absl::OkStatus();
}

absl::Status MemoryStore::DeleteMap(MapKey map) {
  const absl::MutexLock lock(&content_->mutex);
  if (!content_->maps.contains(map)) return NotThere();
  if (!content_->health.ok()) return content_->health;
  content_->maps.erase(map);
  return absl::OkStatus();
}

absl::StatusOr<std::vector<MapRecord>> MemoryStore::ListMaps() {
  std::vector<MapRecord> records;
  const absl::MutexLock lock(&content_->mutex);
  for (const auto& [key, map] : content_->maps) records.push_back(map.record);
  std::sort(records.begin(), records.end(), [](const MapRecord& a, const MapRecord& b) {
    return a.name < b.name;
  });
  return records;
}

absl::StatusOr<StoredState> MemoryStore::LoadMap(const MapRecord& record) {
  const absl::MutexLock lock(&content_->mutex);
  const auto found = content_->maps.find(record.key);
  if (found == content_->maps.end()) return NotThere();
  const StoredMap& map = found->second;
  if (map.damaged) {
    return MakeError(absl::StatusCode::kDataLoss, reason::kChecksum, "damaged as the test asked");
  }
  StoredState state;
  state.durable_head = map.head;
  for (const auto& [name, session] : map.sessions) state.sessions.push_back(session);
  state.snapshot = map.snapshot;
  state.snapshot.last_event = map.last_event;
  return state;
}

absl::Status MemoryStore::AppendFrames(const std::vector<LogAppend>& appends) {
  content_->RunHook();
  const absl::MutexLock lock(&content_->mutex);
  if (!content_->health.ok()) return content_->health;
  if (absl::Status status = content_->CheckDisk(); !status.ok()) return status;
  std::set<MapKey> seen;
  for (const LogAppend& append : appends) {
    if (!seen.insert(append.map).second) return absl::FailedPreconditionError("a map twice");
    const auto map = content_->maps.find(append.map);
    if (map == content_->maps.end()) return NotThere();
    if (absl::Status status = map->second.Check(append); !status.ok()) return status;
  }
  if (absl::Status status = content_->CheckWrite(&content_->fail_append); !status.ok()) {
    return status;
  }
  for (const LogAppend& append : appends) content_->maps.at(append.map).Append(append);
  return absl::OkStatus();
}

absl::Status MemoryStore::CommitRevision(MapKey map, const MapDelta& delta, Timestamp now) {
  content_->RunHook();
  const absl::MutexLock lock(&content_->mutex);
  if (!content_->health.ok()) return content_->health;
  const auto found = content_->maps.find(map);
  if (found == content_->maps.end()) return NotThere();
  StoredMap& stored = found->second;
  if (delta.from != stored.snapshot.revision || delta.to < delta.from ||
      delta.to.value() > stored.head.value()) {
    return absl::FailedPreconditionError("the commit does not fit the map");
  }
  if (delta.to == delta.from) return absl::OkStatus();
  if (absl::Status status = content_->CheckWrite(&content_->fail_commit); !status.ok()) {
    return status;
  }
  EventNumber& number = stored.last_event;
  for (const ObjectEvent& event : delta.events) {
    number = number.Next();
    stored.events.push_back({number, event});
  }
  StoredMap::StoredCommit& commit =
      stored.commits.emplace_back(StoredMap::StoredCommit{delta.from, delta.to, now, {}, {}});
  for (const ObjectChange& object : delta.objects) commit.objects.push_back(object.id);
  for (const LeafChange& leaf : delta.leaves) commit.leaves.push_back(leaf.key);
  return Apply(delta, &stored.snapshot);
}

absl::Status MemoryStore::ReadLog(MapKey map,
                                  MapSequence first,
                                  const std::function<absl::Status(LogFrame)>& visit) {
  std::vector<LogFrame> frames;
  {
    const absl::MutexLock lock(&content_->mutex);
    const auto found = content_->maps.find(map);
    if (found == content_->maps.end()) return NotThere();
    const StoredMap& stored = found->second;
    for (auto frame = stored.log.lower_bound(first); frame != stored.log.end(); ++frame) {
      const FramePose& pose = stored.poses.at(frame->first).pose;
      frames.push_back(
          {pose.sequence, pose.robot, pose.capture_time, pose.T_world_camera, frame->second});
    }
  }
  for (LogFrame& frame : frames) {
    if (absl::Status status = visit(std::move(frame)); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<StoredEvent>> MemoryStore::ReadEvents(MapKey map,
                                                                 EventNumber first,
                                                                 std::size_t limit) {
  const absl::MutexLock lock(&content_->mutex);
  const auto found = content_->maps.find(map);
  if (found == content_->maps.end()) return NotThere();
  std::vector<StoredEvent> events;
  for (const StoredEvent& event : found->second.events) {
    if (event.number >= first && events.size() < limit) events.push_back(event);
  }
  return events;
}

absl::StatusOr<std::vector<FramePose>> MemoryStore::ReadPoses(MapKey map,
                                                              MapSequence first,
                                                              MapSequence last,
                                                              std::size_t limit) {
  const absl::MutexLock lock(&content_->mutex);
  const auto found = content_->maps.find(map);
  if (found == content_->maps.end()) return NotThere();
  const auto& stored = found->second.poses;
  std::vector<FramePose> poses;
  for (auto pose = stored.lower_bound(first);
       pose != stored.end() && pose->first <= last && poses.size() < limit;
       ++pose) {
    poses.push_back(pose->second.pose);
  }
  return poses;
}

absl::StatusOr<ChangeList> MemoryStore::ReadChanges(MapKey map, Revision from, Revision to) {
  const absl::MutexLock lock(&content_->mutex);
  const auto found = content_->maps.find(map);
  if (found == content_->maps.end()) return NotThere();
  ChangeList changes;
  std::set<ObjectId> objects;
  std::set<LeafKey> leaves;
  Revision reached = from;
  for (const StoredMap::StoredCommit& commit : found->second.commits) {
    if (commit.from != reached || reached == to) continue;
    reached = commit.to;
    ++changes.commits;
    objects.insert(commit.objects.begin(), commit.objects.end());
    leaves.insert(commit.leaves.begin(), commit.leaves.end());
  }
  if (reached != to) return Compacted();
  changes.objects.assign(objects.begin(), objects.end());
  changes.leaves.assign(leaves.begin(), leaves.end());
  return changes;
}

absl::Status MemoryStore::Trim(const MapRecord& map, const TrimBounds& bounds) {
  const absl::MutexLock lock(&content_->mutex);
  const auto found = content_->maps.find(map.key);
  if (found == content_->maps.end()) return NotThere();
  if (!content_->health.ok()) return content_->health;
  StoredMap& stored = found->second;
  const MapSequence integrated{std::min(bounds.last.value(), stored.snapshot.revision.value())};
  stored.TrimLog(integrated, bounds.now, map);
  stored.TrimCommits(content_->options, bounds);
  const std::uint64_t head = stored.head.value();
  const MapSequence first_in_log =
      stored.log.empty() ? stored.head.Next() : stored.log.begin()->first;
  std::erase_if(stored.poses, [&](const auto& pose) {
    return pose.first < first_in_log && pose.first.value() + content_->options.kept_poses <= head;
  });
  if (stored.events.size() > content_->options.kept_events) {
    const auto surplus = stored.events.size() - content_->options.kept_events;
    stored.events.erase(stored.events.begin(),
                        stored.events.begin() + static_cast<std::ptrdiff_t>(surplus));
  }
  std::erase_if(stored.sessions, [&](const auto& session) {
    return session.second.last_active < bounds.forget_sessions_before;
  });
  return absl::OkStatus();
}

absl::Status MemoryStore::health() const {
  const absl::MutexLock lock(&content_->mutex);
  return content_->health;
}

}  // namespace steadymap
