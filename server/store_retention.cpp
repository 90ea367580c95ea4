// The retention side of RocksStore: what a trim drops.

#include <algorithm>
#include <utility>

#include <rocksdb/snapshot.h>

#include "core/error.h"
#include "server/rocks_store.h"
#include "server/store_keys.h"
#include "server/store_records.h"

namespace steadymap {
namespace {

// Reclaiming flushes and compacts: done when that much can be won.
constexpr std::uint64_t kReclaimBytes = std::uint64_t{16} << 20;

bool IsOlder(std::int64_t then_ns, Timestamp now, std::chrono::seconds age) {
  return (now.nanoseconds() - then_ns) / kNanosecondsPerSecond >= age.count();
}

absl::StatusOr<storage::v1::PoseRecord> ReadPoseRecord(const StoreDatabase& database,
                                                       MapKey map,
                                                       MapSequence sequence) {
  const std::string key = FrameKey(map, sequence);
  const absl::StatusOr<std::string> value = database.Read(Family::kPose, key);
  if (!value.ok()) return value.status();
  storage::v1::PoseRecord pose;
  const ValuePlace place{NameOf(Family::kPose), key};
  if (absl::Status status = UnsealRecord(place, *value, &pose); !status.ok()) return status;
  return pose;
}

}  // namespace

absl::Status RocksStore::Trim(const MapRecord& map, const TrimBounds& bounds) {
  // Against appends, which would else renew a session between our look and our deletion.
  const WriteTurns::Turn turn(&append_turns_, {map.key});
  absl::StatusOr<MapEntry> entry = Find(map.key);
  if (!entry.ok()) return entry.status();
  entry->record.frame_log_age = map.frame_log_age;
  entry->record.frame_log_bytes = map.frame_log_bytes;
  const MapSequence integrated{std::min(bounds.last.value(), entry->revision_head.revision())};
  rocksdb::WriteBatch batch;
  std::uint64_t dropped_bytes = 0;
  if (absl::Status status = TrimLog(*entry, integrated, bounds.now, &batch, &dropped_bytes);
      !status.ok()) {
    return status;
  }
  if (absl::Status status = TrimChangeLists(*entry, bounds, &batch); !status.ok()) return status;
  if (absl::Status status = TrimEvents(*entry, &batch); !status.ok()) return status;
  if (absl::Status status = TrimSessions(map.key, bounds.forget_sessions_before, &batch);
      !status.ok()) {
    return status;
  }
  if (batch.Count() == 0) return absl::OkStatus();
  if (absl::Status status = database_->Write(&batch); !status.ok()) return status;
  if (unreclaimed_bytes_.fetch_add(dropped_bytes) + dropped_bytes >= kReclaimBytes) {
    unreclaimed_bytes_ = 0;
    database_->Reclaim(Family::kLog);
  }
  return absl::OkStatus();
}

absl::Status RocksStore::TrimLog(const MapEntry& entry,
                                 MapSequence last,
                                 Timestamp now,
                                 rocksdb::WriteBatch* batch,
                                 std::uint64_t* dropped_bytes) const {
  const MapKey map = entry.record.key;
  const absl::StatusOr<std::optional<std::uint64_t>> first_frame = FirstNumber(Family::kLog, map);
  if (!first_frame.ok()) return first_frame.status();
  MapSequence kept{entry.log_head.durable_map_seq() + 1};  // First frame that the log keeps.
  if (first_frame->has_value()) {
    const MapSequence first{**first_frame};
    const absl::StatusOr<MapSequence> cut = FindLogCut(entry, first, last, now);
    if (!cut.ok()) return cut.status();
    kept = *cut;
    if (kept > first) {
      const absl::StatusOr<std::uint64_t> first_bytes = BytesBefore(entry, first);
      const absl::StatusOr<std::uint64_t> kept_bytes = BytesBefore(entry, kept);
      if (!first_bytes.ok()) return first_bytes.status();
      if (!kept_bytes.ok()) return kept_bytes.status();
      *dropped_bytes = *kept_bytes - *first_bytes;
      batch->DeleteRange(
          database_->handle(Family::kLog), FrameKey(map, first), FrameKey(map, kept));
    }
  }
  const absl::StatusOr<std::optional<std::uint64_t>> first_pose = FirstNumber(Family::kPose, map);
  if (!first_pose.ok()) return first_pose.status();
  const std::uint64_t head = entry.log_head.durable_map_seq();
  const std::uint64_t surplus = head - std::min(head, options_.kept_poses);
  const MapSequence kept_pose{std::min(kept.value(), surplus + 1)};
  if (first_pose->has_value() && kept_pose.value() > **first_pose) {
    batch->DeleteRange(database_->handle(Family::kPose),
                       FrameKey(map, MapSequence{**first_pose}),
                       FrameKey(map, kept_pose));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::uint64_t> RocksStore::BytesBefore(const MapEntry& entry,
                                                      MapSequence sequence) const {
  if (sequence.value() > entry.log_head.durable_map_seq()) return entry.log_head.total_bytes();
  const absl::StatusOr<storage::v1::PoseRecord> pose =
      ReadPoseRecord(*database_, entry.record.key, sequence);
  if (!pose.ok()) return pose.status();
  return pose->bytes_before();
}

absl::StatusOr<MapSequence> RocksStore::FindLogCut(const MapEntry& entry,
                                                   MapSequence first,
                                                   MapSequence last,
                                                   Timestamp now) const {
  // Both rules want a suffix of the log, so the first wanted frame can be searched by halving.
  std::uint64_t low = first.value();
  std::uint64_t high = last.value() + 1;
  while (low < high) {
    const std::uint64_t middle = low + (high - low) / 2;
    const absl::StatusOr<storage::v1::PoseRecord> pose =
        ReadPoseRecord(*database_, entry.record.key, MapSequence{middle});
    if (!pose.ok()) return pose.status();
    const std::uint64_t bytes_from_here = entry.log_head.total_bytes() - pose->bytes_before();
    const bool unwanted = bytes_from_here > entry.record.frame_log_bytes ||
                          IsOlder(pose->append_time_ns(), now, entry.record.frame_log_age);
    (unwanted ? low : high) = unwanted ? middle + 1 : middle;
  }
  return MapSequence{low};
}

absl::StatusOr<std::optional<std::uint64_t>> RocksStore::FirstNumber(Family family,
                                                                     MapKey map) const {
  const KeyRange range = MapRange(map);
  const rocksdb::Slice upper_bound(range.end);
  const std::unique_ptr<rocksdb::Iterator> scan = database_->Scan(family, &upper_bound);
  scan->Seek(range.begin);
  if (!scan->status().ok()) return FromRocksdb(scan->status(), "looking for what is oldest");
  if (!scan->Valid()) return std::optional<std::uint64_t>();
  const ValuePlace place{NameOf(family), scan->key().ToStringView()};
  const std::optional<std::uint64_t> number = NumberOfKey(place.key);
  if (!number) return DamagedValue(place, "is filed under no number");
  return number;
}

absl::Status RocksStore::TrimChangeLists(const MapEntry& entry,
                                         const TrimBounds& bounds,
                                         rocksdb::WriteBatch* batch) const {
  const KeyRange range = MapRange(entry.record.key);
  const rocksdb::Slice upper_bound(range.end);
  const std::unique_ptr<rocksdb::Iterator> scan = database_->Scan(Family::kChange, &upper_bound);
  std::string kept = range.begin;
  for (scan->Seek(range.begin); scan->Valid(); scan->Next()) {
    const ValuePlace place{NameOf(Family::kChange), scan->key().ToStringView()};
    storage::v1::ChangeRecord change;
    if (absl::Status status = UnsealRecord(place, scan->value().ToStringView(), &change);
        !status.ok()) {
      return status;
    }
    const bool surplus =
        entry.revision_head.commits() - change.ordinal() >= options_.kept_change_lists;
    const bool old = IsOlder(change.commit_time_ns(), bounds.now, options_.change_list_age);
    if (!surplus && !old) break;
    const std::optional<std::uint64_t> revision = NumberOfKey(place.key);
    if (!revision) return DamagedValue(place, "is filed under no revision");
    if (bounds.oldest_watched && *revision > bounds.oldest_watched->value() &&
        !IsOlder(change.commit_time_ns(),
                 bounds.now,
                 options_.change_list_age + options_.change_list_grace)) {
      break;
    }
    // The smallest key behind this one.
    kept = scan->key().ToString() + '\0';
  }
  if (!scan->status().ok()) return FromRocksdb(scan->status(), "reading change lists");
  if (kept != range.begin) {
    batch->DeleteRange(database_->handle(Family::kChange), range.begin, kept);
  }
  return absl::OkStatus();
}

absl::Status RocksStore::TrimEvents(const MapEntry& entry, rocksdb::WriteBatch* batch) const {
  const MapKey map = entry.record.key;
  const absl::StatusOr<std::optional<std::uint64_t>> first = FirstNumber(Family::kEvent, map);
  if (!first.ok()) return first.status();
  const std::uint64_t events = entry.revision_head.events();
  const std::uint64_t surplus = events - std::min(events, options_.kept_events);
  if (first->has_value() && **first <= surplus) {
    batch->DeleteRange(database_->handle(Family::kEvent),
                       EventKey(map, EventNumber{**first}),
                       EventKey(map, EventNumber{surplus + 1}));
  }
  return absl::OkStatus();
}

absl::Status RocksStore::TrimSessions(MapKey map,
                                      Timestamp forget_before,
                                      rocksdb::WriteBatch* batch) const {
  const KeyRange range = MapRange(map);
  const rocksdb::Slice upper_bound(range.end);
  const std::unique_ptr<rocksdb::Iterator> scan = database_->Scan(Family::kDedup, &upper_bound);
  for (scan->Seek(range.begin); scan->Valid(); scan->Next()) {
    const ValuePlace place{NameOf(Family::kDedup), scan->key().ToStringView()};
    storage::v1::SessionRecord session;
    if (absl::Status status = UnsealRecord(place, scan->value().ToStringView(), &session);
        !status.ok()) {
      return status;
    }
    if (session.last_active_ns() < forget_before.nanoseconds()) {
      batch->Delete(database_->handle(Family::kDedup), scan->key());
    }
  }
  return FromRocksdb(scan->status(), "reading upload sessions");
}

}  // namespace steadymap
