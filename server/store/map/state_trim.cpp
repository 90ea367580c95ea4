#include "server/store/map/state_trim.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "server/store/database/store_keys.h"
#include "server/store/map/state_reading.h"

namespace steadymap {
namespace {

bool IsOlder(std::int64_t then_ns, MapUptime now, std::chrono::seconds age) {
  return now - MapUptime(then_ns) >= age;
}

absl::StatusOr<std::optional<std::uint64_t>> FirstNumber(const StateDatabase& state,
                                                         Family family) {
  const KeyRange range = RangeOf(family);
  const rocksdb::Slice upper_bound(range.end);
  const std::unique_ptr<rocksdb::Iterator> scan = state.Scan(family, &upper_bound);
  scan->Seek(range.begin);
  if (!scan->status().ok()) return FromRocksdb(scan->status(), "looking for the oldest record");
  if (!scan->Valid()) return std::optional<std::uint64_t>();
  const ValuePlace place{NameOf(family), scan->key().ToStringView()};
  const std::optional<std::uint64_t> number = NumberOfKey(place.key);
  if (!number) return DamagedValue(place, "has a key that does not contain a number");
  return number;
}

}  // namespace

absl::Status TrimPoses(const StateDatabase& state,
                       const StoreOptions& options,
                       const storage::v1::Head& head,
                       rocksdb::WriteBatch* batch) {
  const absl::StatusOr<std::optional<std::uint64_t>> first = FirstNumber(state, Family::kPose);
  if (!first.ok()) return first.status();
  const std::uint64_t newest = head.revision();
  const std::uint64_t surplus = newest - std::min(newest, options.kept_poses);
  if (first->has_value() && surplus >= **first) {
    batch->DeleteRange(state.handle(Family::kPose),
                       PoseKey(MapSequence{**first}),
                       PoseKey(MapSequence{surplus + 1}));
  }
  return absl::OkStatus();
}

absl::Status TrimChangeLists(const StateDatabase& state,
                             const StoreOptions& options,
                             const storage::v1::Head& head,
                             const TrimBounds& bounds,
                             rocksdb::WriteBatch* batch) {
  const KeyRange range = RangeOf(Family::kChange);
  const rocksdb::Slice upper_bound(range.end);
  const std::unique_ptr<rocksdb::Iterator> scan = state.Scan(Family::kChange, &upper_bound);
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
    if (!revision) return DamagedValue(place, "has a key that is not a revision key");
    if (bounds.oldest_watched && *revision > bounds.oldest_watched->value() &&
        !IsOlder(change.uptime_ns(),
                 bounds.uptime,
                 options.change_list_age + options.change_list_grace)) {
      break;
    }
    // The smallest key greater than this one.
    kept = scan->key().ToString() + '\0';
  }
  if (!scan->status().ok()) return FromRocksdb(scan->status(), "reading change lists");
  if (kept != range.begin) {
    batch->DeleteRange(state.handle(Family::kChange), range.begin, kept);
  }
  return absl::OkStatus();
}

absl::Status TrimEvents(const StateDatabase& state,
                        const StoreOptions& options,
                        const storage::v1::Head& head,
                        rocksdb::WriteBatch* batch) {
  const absl::StatusOr<std::optional<std::uint64_t>> first = FirstNumber(state, Family::kEvent);
  if (!first.ok()) return first.status();
  const std::uint64_t events = head.events();
  const std::uint64_t surplus = events - std::min(events, options.kept_events);
  if (first->has_value() && **first <= surplus) {
    batch->DeleteRange(state.handle(Family::kEvent),
                       EventKey(EventNumber{**first}),
                       EventKey(EventNumber{surplus + 1}));
  }
  return absl::OkStatus();
}

bool IsIdle(const SessionRecord& session, const TrimBounds& bounds) {
  return session.last_active < bounds.forget_sessions_before &&
         !bounds.sessions_in_use.contains(session.name);
}

absl::Status TrimSessions(const StateDatabase& state,
                          const TrimBounds& bounds,
                          rocksdb::WriteBatch* batch) {
  return ForEachRecord(
      state, Family::kSession, nullptr, [&](const ValuePlace& place, std::string_view value) {
        storage::v1::SessionRecord proto;
        if (absl::Status status = UnsealRecord(place, value, &proto); !status.ok()) return status;
        const absl::StatusOr<SessionRecord> session = FromProto(proto);
        if (!session.ok()) return session.status();
        if (IsIdle(*session, bounds)) {
          batch->Delete(state.handle(Family::kSession), std::string(place.key));
        }
        return absl::OkStatus();
      });
}

}  // namespace steadymap
