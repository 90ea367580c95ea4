#include "tests/support/memory_store.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <deque>
#include <iterator>
#include <set>
#include <string>
#include <utility>

#include "core/types/error.h"
#include "server/store/model/history_hash.h"

namespace steadymap {
namespace {

absl::Status NotThere() {
  return MakeError(absl::StatusCode::kNotFound, reason::kNotFound, "no such map");
}

absl::Status Compacted() {
  return MakeError(
      absl::StatusCode::kOutOfRange, reason::kRevisionCompacted, "the change list was compacted");
}

}  // namespace

/// Content of one map, as on a disk.
struct MemoryStore::StoredMap {
  /// Entries of one append; a trim drops whole groups.
  struct Group {
    std::vector<LogEntry> entries;
    MapUptime uptime{0};
    std::uint64_t bytes = 0;
  };

  /// Changes of a commit, and the data for their retention.
  struct StoredCommit {
    CommitMark from;
    Revision to;
    MapUptime uptime{0};
    std::vector<ObjectId> objects;
    std::vector<LeafKey> leaves;
  };

  absl::Status Check(const LogAppend& append) const;
  void Append(const LogAppend& append);
  void TrimLog(MapUptime uptime, const MapRecord& retention, bool disk_is_low);
  void TrimCommits(const StoreOptions& options, const TrimBounds& bounds);

  MapRecord record;
  bool damaged = false;
  absl::Status health;
  MapSequence head;
  MapUptime uptime{0};
  std::vector<SemanticClass> added_classes;  // Up to `head`.
  MapSnapshot snapshot;
  std::uint64_t history_hash = 0;
  std::vector<StoredEvent> events;
  std::deque<StoredCommit> commits;
  std::deque<Group> log;
  std::map<MapSequence, FramePose> poses;
  std::map<SessionName, SessionRecord> sessions;
  std::shared_ptr<IntegrationNote> note = IntegrationNote::InMemory();
};

absl::Status MemoryStore::StoredMap::Check(const LogAppend& append) const {
  MapSequence last = head;
  for (const LogEntry& entry : append.entries) {
    if (entry.sequence != last.Next()) return absl::FailedPreconditionError("a gap in the log");
    last = entry.sequence;
  }
  for (const SessionRecord& session : append.sessions) {
    if (!IsValidId(session.name.sensor.robot) || !IsValidId(session.name.session)) {
      return InvalidField(reason::kBadName, "session", "no valid id");
    }
  }
  return absl::OkStatus();
}

void MemoryStore::StoredMap::Append(const LogAppend& append) {
  uptime = std::max(uptime, append.uptime);
  Group group{append.entries, append.uptime, 0};
  for (const LogEntry& entry : append.entries) {
    head = entry.sequence;
    group.bytes += entry.packed_frame.size();
    added_classes.insert(added_classes.end(), entry.classes.begin(), entry.classes.end());
  }
  if (!append.entries.empty()) log.push_back(std::move(group));
  for (const SessionRecord& session : append.sessions) sessions[session.name] = session;
}

void MemoryStore::StoredMap::TrimLog(MapUptime now, const MapRecord& retention, bool disk_is_low) {
  std::uint64_t bytes = 0;
  for (const Group& group : log) bytes += group.bytes;
  while (!log.empty()) {
    const Group& oldest = log.front();
    const MapUptime youngest = log.size() > 1 ? log[1].uptime : oldest.uptime;
    const bool wanted = !disk_is_low && bytes <= retention.frame_log_bytes &&
                        now - youngest < retention.frame_log_age;
    if (wanted || oldest.entries.back().sequence.value() > snapshot.revision.value()) return;
    bytes -= oldest.bytes;
    log.pop_front();
  }
}

void MemoryStore::StoredMap::TrimCommits(const StoreOptions& options, const TrimBounds& bounds) {
  const auto is_older = [&](const StoredCommit& commit, std::chrono::seconds age) {
    return bounds.uptime - commit.uptime >= age;
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
  bool broken ABSL_GUARDED_BY(mutex) = false;
  bool fail_append ABSL_GUARDED_BY(mutex) = false;
  bool fail_commit ABSL_GUARDED_BY(mutex) = false;
  bool disk_low ABSL_GUARDED_BY(mutex) = false;
  std::function<bool()> is_low_for_append ABSL_GUARDED_BY(mutex);
  std::function<void()> write_hook ABSL_GUARDED_BY(mutex);

  absl::Status CheckDisk(bool asks_test) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex) {
    const bool is_low = asks_test && is_low_for_append && is_low_for_append();
    if (!disk_low && !is_low) return absl::OkStatus();
    return MakeError(absl::StatusCode::kResourceExhausted, reason::kDiskLow, "the disk is full");
  }

  /// Fails the map like a failed sync if `*fault` is true.
  absl::Status CheckWrite(bool* fault, StoredMap* map) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex) {
    if (std::exchange(*fault, false)) {
      broken = true;
      map->health = MakeError(absl::StatusCode::kUnavailable,
                              reason::kStoreReadOnly,
                              "a sync failed on request of the test");
    }
    return map->health;
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
  content_->broken = false;
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
  std::size_t entries = 0;
  for (const StoredMap::Group& group : content_->maps.at(map).log) entries += group.entries.size();
  return entries;
}

absl::StatusOr<MapRecord> MemoryStore::CreateMap(const MapRecord& record) {
  if (!IsValidId(record.name.tenant) || !IsValidId(record.name.map)) {
    return InvalidField(reason::kBadName, "name", "no valid ids");
  }
  const absl::MutexLock lock(&content_->mutex);
  if (absl::Status status = content_->CheckDisk(false); !status.ok()) return status;
  if (content_->HasName(record.name)) {
    return MakeError(absl::StatusCode::kAlreadyExists, reason::kAlreadyExists, "exists already");
  }
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
  map->second.record = record;
  return absl::OkStatus();
}

absl::Status MemoryStore::DeleteMap(MapKey map) {
  const absl::MutexLock lock(&content_->mutex);
  if (!content_->maps.contains(map)) return NotThere();
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
  StoredMap& map = found->second;
  if (map.damaged) {
    return MakeError(absl::StatusCode::kDataLoss, reason::kChecksum, "damaged by the test");
  }
  if (!map.health.ok() && content_->broken) return map.health;
  map.health = absl::OkStatus();
  StoredState state;
  state.durable_head = map.head;
  state.durable_classes = map.record.config.classes;
  state.durable_classes.insert(
      state.durable_classes.end(), map.added_classes.begin(), map.added_classes.end());
  for (const auto& [name, session] : map.sessions) state.sessions.push_back(session);
  state.snapshot = map.snapshot;
  state.commit = {map.snapshot.revision, map.history_hash};
  state.uptime = map.uptime;
  state.note = map.note;
  return state;
}

absl::Status MemoryStore::Append(const LogAppend& append) {
  content_->RunHook();
  const absl::MutexLock lock(&content_->mutex);
  const auto found = content_->maps.find(append.map);
  if (found == content_->maps.end()) return NotThere();
  StoredMap& map = found->second;
  if (!map.health.ok()) return map.health;
  if (absl::Status status = content_->CheckDisk(true); !status.ok()) return status;
  if (absl::Status status = map.Check(append); !status.ok()) return status;
  if (absl::Status status = content_->CheckWrite(&content_->fail_append, &map); !status.ok()) {
    return status;
  }
  map.Append(append);
  return absl::OkStatus();
}

absl::StatusOr<CommitMark> MemoryStore::CommitRevision(MapKey map,
                                                       const MapDelta& delta,
                                                       const CommitDetails& details) {
  content_->RunHook();
  const absl::MutexLock lock(&content_->mutex);
  const auto found = content_->maps.find(map);
  if (found == content_->maps.end()) return NotThere();
  StoredMap& stored = found->second;
  if (!stored.health.ok()) return stored.health;
  const CommitMark before{stored.snapshot.revision, stored.history_hash};
  if (delta.from != before.revision || delta.to < delta.from ||
      delta.to.value() > stored.head.value()) {
    return absl::FailedPreconditionError("the commit does not fit the map");
  }
  if (delta.to == delta.from) return before;
  if (absl::Status status = content_->CheckDisk(false); !status.ok()) return status;
  if (absl::Status status = content_->CheckWrite(&content_->fail_commit, &stored); !status.ok()) {
    return status;
  }
  stored.uptime = std::max(stored.uptime, details.uptime);
  EventNumber number = stored.snapshot.last_event;
  for (const ObjectEvent& event : delta.events) {
    number = number.Next();
    stored.events.push_back({number, event});
  }
  for (const FramePose& pose : details.poses) stored.poses[pose.sequence] = pose;
  StoredMap::StoredCommit& commit = stored.commits.emplace_back(
      StoredMap::StoredCommit{before, delta.to, details.uptime, {}, {}});
  std::string change;
  for (const ObjectChange& object : delta.objects) commit.objects.push_back(object.id);
  for (const LeafChange& leaf : delta.leaves) {
    commit.leaves.push_back(leaf.key);
    change += leaf.packed;
  }
  if (absl::Status status = Apply(delta, &stored.snapshot); !status.ok()) return status;
  stored.snapshot.last_event = number;
  stored.history_hash = ExtendHistory(before.hash, delta.to, change);
  return CommitMark{delta.to, stored.history_hash};
}

absl::Status MemoryStore::ReadLog(MapKey map,
                                  MapSequence first,
                                  const std::function<absl::Status(LogEntry)>& visit) {
  std::vector<LogEntry> entries;
  {
    const absl::MutexLock lock(&content_->mutex);
    const auto found = content_->maps.find(map);
    if (found == content_->maps.end()) return NotThere();
    for (const StoredMap::Group& group : found->second.log) {
      for (const LogEntry& entry : group.entries) {
        if (entry.sequence >= first) entries.push_back(entry);
      }
    }
  }
  for (LogEntry& entry : entries) {
    if (absl::Status status = visit(std::move(entry)); !status.ok()) return status;
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
    poses.push_back(pose->second);
  }
  return poses;
}

absl::StatusOr<ChangeList> MemoryStore::ReadChanges(MapKey map, CommitMark from, Revision to) {
  const absl::MutexLock lock(&content_->mutex);
  const auto found = content_->maps.find(map);
  if (found == content_->maps.end()) return NotThere();
  ChangeList changes;
  std::set<ObjectId> objects;
  std::set<LeafKey> leaves;
  Revision reached = from.revision;
  for (const StoredMap::StoredCommit& commit : found->second.commits) {
    if (commit.from.revision != reached || reached == to) continue;
    if (commit.from.revision == from.revision && commit.from.hash != from.hash) break;
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
  StoredMap& stored = found->second;
  if (!stored.health.ok()) return stored.health;
  stored.uptime = std::max(stored.uptime, bounds.uptime);
  stored.TrimLog(bounds.uptime, map, bounds.disk_is_low);
  stored.TrimCommits(content_->options, bounds);
  const std::uint64_t newest = stored.snapshot.revision.value();
  std::erase_if(stored.poses, [&](const auto& pose) {
    return pose.first.value() + content_->options.kept_poses <= newest;
  });
  if (stored.events.size() > content_->options.kept_events) {
    const auto surplus = stored.events.size() - content_->options.kept_events;
    stored.events.erase(stored.events.begin(),
                        stored.events.begin() + static_cast<std::ptrdiff_t>(surplus));
  }
  std::erase_if(stored.sessions, [&](const auto& session) {
    return session.second.last_active < bounds.forget_sessions_before &&
           !bounds.sessions_in_use.contains(session.first);
  });
  return absl::OkStatus();
}

absl::Status MemoryStore::health(MapKey map) const {
  const absl::MutexLock lock(&content_->mutex);
  const auto found = content_->maps.find(map);
  return found == content_->maps.end() ? NotThere() : found->second.health;
}

absl::Status MemoryStore::CheckDisk() const {
  const absl::MutexLock lock(&content_->mutex);
  return content_->CheckDisk(false);
}

}  // namespace steadymap
