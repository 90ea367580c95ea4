// What a trim drops of a map.

#include <algorithm>
#include <utility>

#include "core/error.h"
#include "server/map_database.h"
#include "server/store_keys.h"

namespace steadymap {
namespace {

// A map that rests is written to once in a while, so that its uptime is not lost.
constexpr MapUptime kUptimeStep = std::chrono::minutes(10);

bool IsOlder(std::int64_t then_ns, MapUptime now, std::chrono::seconds age) {
  return now - MapUptime(then_ns) >= age;
}

}  // namespace

absl::Status MapDatabase::Trim(const MapRecord& retention, const TrimBounds& bounds) {
  // Where there is no room to write, what the database knows already can be dropped all the same.
  absl::Status status = state_->health();
  if (status.ok()) status = CheckFree(surroundings_.options->write_buffer_bytes);
  if (status.ok()) {
    const WriteTurn::Held turn(&commit_turn_);
    status = TrimState(bounds);
  }
  const bool keeps_log = !bounds.disk_is_low;
  const WriteTurn::Held turn(&append_turn_);
  const storage::v1::Head head = progress().head;
  const absl::Status dropped =
      log_->Drop({MapSequence(head.revision()), head.saved_group()},
                 keeps_log ? retention.frame_log_bytes : 0,
                 bounds.uptime,
                 keeps_log ? retention.frame_log_age : std::chrono::seconds(0));
  return status.ok() ? dropped : status;
}

absl::Status MapDatabase::TrimState(const TrimBounds& bounds) {
  rocksdb::WriteBatch batch;
  if (absl::Status status = TrimSessions(bounds, &batch); !status.ok()) {
    return status;
  }
  // After the idle sessions were looked for: one that is renewed meanwhile is put again.
  const Progress progress = this->progress();
  storage::v1::Head head = progress.head;
  if (absl::Status status = TrimPoses(head, &batch); !status.ok()) return status;
  if (absl::Status status = TrimChangeLists(head, bounds, &batch); !status.ok()) return status;
  if (absl::Status status = TrimEvents(head, &batch); !status.ok()) return status;
  const bool knows_all = progress.group == head.saved_group() &&
                         progress.durable_head.value() == head.durable_map_seq();
  const bool is_young = bounds.uptime - MapUptime(head.uptime_ns()) < kUptimeStep;
  if (batch.Count() == 0 && knows_all && is_young) return absl::OkStatus();
  head.set_uptime_ns(std::max<std::int64_t>(head.uptime_ns(), bounds.uptime.count()));
  PutProgress(progress, &head, &batch);
  if (absl::Status status = state_->Write(&batch); !status.ok()) return status;
  ForgetSaved(head);
  return absl::OkStatus();
}

absl::Status MapDatabase::TrimPoses(const storage::v1::Head& head,
                                    rocksdb::WriteBatch* batch) const {
  const absl::StatusOr<std::optional<std::uint64_t>> first = FirstNumber(Family::kPose);
  if (!first.ok()) return first.status();
  const std::uint64_t newest = head.revision();
  const std::uint64_t surplus = newest - std::min(newest, surroundings_.options->kept_poses);
  if (first->has_value() && surplus >= **first) {
    batch->DeleteRange(state_->handle(Family::kPose),
                       PoseKey(MapSequence{**first}),
                       PoseKey(MapSequence{surplus + 1}));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::optional<std::uint64_t>> MapDatabase::FirstNumber(Family family) const {
  const KeyRange range = RangeOf(family);
  const rocksdb::Slice upper_bound(range.end);
  const std::unique_ptr<rocksdb::Iterator> scan = state_->Scan(family, &upper_bound);
  scan->Seek(range.begin);
  if (!scan->status().ok()) return FromRocksdb(scan->status(), "looking for what is oldest");
  if (!scan->Valid()) return std::optional<std::uint64_t>();
  const ValuePlace place{NameOf(family), scan->key().ToStringView()};
  const std::optional<std::uint64_t> number = NumberOfKey(place.key);
  if (!number) return DamagedValue(place, "is filed under no number");
  return number;
}

absl::Status MapDatabase::TrimChangeLists(const storage::v1::Head& head,
                                          const TrimBounds& bounds,
                                          rocksdb::WriteBatch* batch) const {
  const StoreOptions& options = *surroundings_.options;
  const KeyRange range = RangeOf(Family::kChange);
  const rocksdb::Slice upper_bound(range.end);
  const std::unique_ptr<rocksdb::Iterator> scan = state_->Scan(Family::kChange, &upper_bound);
  std::string kept = range.begin;
  for (scan->Seek(range.begin); scan->Valid(); scan->Next()) {
    const ValuePlace place{NameOf(Family::kChange), scan->key().ToStringView()};
    storage::v1::ChangeRecord change;
    if (absl::Status status = UnsealRecord(place, scan->value().ToStringView(), &change);
        !status.ok()) {
      return status;
    }
    const bool surplus = head.commits() - change.ordinal() >= options.kept_change_lists;
    const bool old = IsOlder(change.uptime_ns(), bounds.uptime, options.change_list_age);
    if (!surplus && !old) break;
    const std::optional<std::uint64_t> revision = NumberOfKey(place.key);
    if (!revision) return DamagedValue(place, "is filed under no revision");
    if (bounds.oldest_watched && *revision > bounds.oldest_watched->value() &&
        !IsOlder(change.uptime_ns(),
                 bounds.uptime,
                 options.change_list_age + options.change_list_grace)) {
      break;
    }
    // The smallest key behind this one.
    kept = scan->key().ToString() + '\0';
  }
  if (!scan->status().ok()) return FromRocksdb(scan->status(), "reading change lists");
  if (kept != range.begin) {
    batch->DeleteRange(state_->handle(Family::kChange), range.begin, kept);
  }
  return absl::OkStatus();
}

absl::Status MapDatabase::TrimEvents(const storage::v1::Head& head,
                                     rocksdb::WriteBatch* batch) const {
  const absl::StatusOr<std::optional<std::uint64_t>> first = FirstNumber(Family::kEvent);
  if (!first.ok()) return first.status();
  const std::uint64_t events = head.events();
  const std::uint64_t surplus = events - std::min(events, surroundings_.options->kept_events);
  if (first->has_value() && **first <= surplus) {
    batch->DeleteRange(state_->handle(Family::kEvent),
                       EventKey(EventNumber{**first}),
                       EventKey(EventNumber{surplus + 1}));
  }
  return absl::OkStatus();
}

absl::Status MapDatabase::TrimSessions(const TrimBounds& bounds, rocksdb::WriteBatch* batch) {
  const auto is_idle = [&bounds](const SessionRecord& session) {
    return session.last_active < bounds.forget_sessions_before &&
           !bounds.sessions_in_use.contains(session.name);
  };
  {
    const absl::MutexLock lock(&mutex_);
    std::erase_if(progress_.unsaved_sessions,
                  [&](const auto& unsaved) { return is_idle(unsaved.second.record); });
  }
  return ForEachRecord(
      Family::kSession, nullptr, [&](const ValuePlace& place, std::string_view value) {
        storage::v1::SessionRecord proto;
        if (absl::Status status = UnsealRecord(place, value, &proto); !status.ok()) return status;
        const absl::StatusOr<SessionRecord> session = FromProto(proto);
        if (!session.ok()) return session.status();
        if (is_idle(*session)) {
          batch->Delete(state_->handle(Family::kSession), std::string(place.key));
        }
        return absl::OkStatus();
      });
}

}  // namespace steadymap
