#include "server/store/map/map_history.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <absl/strings/str_cat.h>

#include "core/types/error.h"
#include "server/store/database/object_records.h"
#include "server/store/database/store_keys.h"
#include "server/store/database/store_records.h"

#include "steadymap/storage/v1/records.pb.h"

namespace steadymap {
namespace {

absl::Status CompactedError(Revision from, Revision to) {
  return MakeError(absl::StatusCode::kOutOfRange,
                   reason::kRevisionCompacted,
                   absl::StrCat("the changes between revisions ",
                                from.value(),
                                " and ",
                                to.value(),
                                " are no longer stored"));
}

absl::Status AddChanges(const ValuePlace& place,
                        const storage::v1::ChangeRecord& record,
                        ChangeList* changes) {
  ++changes->commits;
  for (const std::uint64_t id : record.objects()) changes->objects.emplace_back(id);
  const std::string_view packed = record.leaf_keys();
  for (std::size_t at = 0; at < packed.size(); at += kPackedLeafKeyBytes) {
    const std::optional<LeafKey> key = UnpackLeafKey(packed.substr(at, kPackedLeafKeyBytes));
    if (!key) return DamagedValue(place, "contains an invalid leaf key");
    changes->leaves.push_back(*key);
  }
  return absl::OkStatus();
}

template <typename Key>
void SortUnique(std::vector<Key>* keys) {
  std::sort(keys->begin(), keys->end());
  keys->erase(std::unique(keys->begin(), keys->end()), keys->end());
}

}  // namespace

absl::StatusOr<ChangeList> ReadChanges(const StateDatabase& state, CommitMark from, Revision to) {
  ChangeList changes;
  const std::string end = ChangeKey(to.Next());
  const rocksdb::Slice upper_bound(end);
  const std::unique_ptr<rocksdb::Iterator> scan = state.Scan(Family::kChange, &upper_bound);
  // Each commit contains the previous revision and its hash, so a missing change list and a
  // different history are both detected.
  Revision reached = from.revision;
  bool is_first = true;
  for (scan->Seek(ChangeKey(from.revision.Next())); scan->Valid(); scan->Next()) {
    const ValuePlace place{NameOf(Family::kChange), scan->key().ToStringView()};
    storage::v1::ChangeRecord record;
    absl::Status status = UnsealRecord(place, scan->value().ToStringView(), &record);
    if (!status.ok()) return status;
    if (record.previous_revision() != reached.value() ||
        (std::exchange(is_first, false) && record.previous_history_hash() != from.hash)) {
      return CompactedError(from.revision, to);
    }
    const std::optional<std::uint64_t> revision = NumberOfKey(place.key);
    if (!revision) return DamagedValue(place, "has a key that is not a revision key");
    reached = Revision(*revision);
    status = AddChanges(place, record, &changes);
    if (!status.ok()) return status;
  }
  if (!scan->status().ok()) return FromRocksdb(scan->status(), "reading change lists");
  if (reached != to) return CompactedError(from.revision, to);
  SortUnique(&changes.objects);
  SortUnique(&changes.leaves);
  return changes;
}

absl::StatusOr<std::vector<StoredEvent>> ReadEvents(const StateDatabase& state,
                                                    EventNumber first,
                                                    std::size_t limit) {
  std::vector<StoredEvent> events;
  const std::string end = RangeOf(Family::kEvent).end;
  const rocksdb::Slice upper_bound(end);
  const std::unique_ptr<rocksdb::Iterator> scan = state.Scan(Family::kEvent, &upper_bound);
  for (scan->Seek(EventKey(first)); scan->Valid() && events.size() < limit; scan->Next()) {
    const ValuePlace place{NameOf(Family::kEvent), scan->key().ToStringView()};
    const std::optional<EventNumber> number = EventOfKey(place.key);
    if (!number) return DamagedValue(place, "has a key that is not an event key");
    storage::v1::EventRecord record;
    if (absl::Status status = UnsealRecord(place, scan->value().ToStringView(), &record);
        !status.ok()) {
      return status;
    }
    absl::StatusOr<ObjectEvent> event = FromProto(record);
    if (!event.ok()) return event.status();
    events.push_back({*number, *std::move(event)});
  }
  if (!scan->status().ok()) return FromRocksdb(scan->status(), "reading events");
  return events;
}

absl::StatusOr<std::vector<FramePose>> ReadPoses(const StateDatabase& state,
                                                 MapSequence first,
                                                 MapSequence last,
                                                 std::size_t limit) {
  std::vector<FramePose> poses;
  const std::string end = RangeOf(Family::kPose).end;
  const rocksdb::Slice upper_bound(end);
  const std::unique_ptr<rocksdb::Iterator> scan = state.Scan(Family::kPose, &upper_bound);
  for (scan->Seek(PoseKey(first)); scan->Valid() && poses.size() < limit; scan->Next()) {
    const ValuePlace place{NameOf(Family::kPose), scan->key().ToStringView()};
    const std::optional<MapSequence> sequence = SequenceOfPoseKey(place.key);
    if (!sequence) return DamagedValue(place, "has a key that is not a pose key");
    if (*sequence > last) break;
    storage::v1::PoseRecord record;
    if (absl::Status status = UnsealRecord(place, scan->value().ToStringView(), &record);
        !status.ok()) {
      return status;
    }
    absl::StatusOr<FramePose> pose = FromProto(*sequence, record);
    if (!pose.ok()) return pose.status();
    poses.push_back(*std::move(pose));
  }
  if (!scan->status().ok()) return FromRocksdb(scan->status(), "reading poses");
  return poses;
}

}  // namespace steadymap
