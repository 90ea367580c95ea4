// How RocksStore tells what commits changed.

#include <algorithm>
#include <memory>
#include <string>
#include <string_view>

#include <absl/strings/str_cat.h>

#include "core/error.h"
#include "server/rocks_store.h"
#include "server/store_keys.h"
#include "server/store_records.h"

namespace steadymap {
namespace {

absl::Status CompactedError(Revision from, Revision to) {
  return MakeError(absl::StatusCode::kOutOfRange,
                   reason::kRevisionCompacted,
                   absl::StrCat("what changed between revisions ",
                                from.value(),
                                " and ",
                                to.value(),
                                " is no longer known"));
}

absl::Status AddChanges(const ValuePlace& place,
                        const storage::v1::ChangeRecord& record,
                        ChangeList* changes) {
  ++changes->commits;
  for (const std::uint64_t id : record.objects()) changes->objects.emplace_back(id);
  const std::string_view packed = record.leaf_keys();
  for (std::size_t at = 0; at < packed.size(); at += kPackedLeafKeyBytes) {
    const std::optional<LeafKey> key = UnpackLeafKey(packed.substr(at, kPackedLeafKeyBytes));
    if (!key) return DamagedValue(place, "names no leaf");
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

absl::StatusOr<ChangeList> RocksStore::ReadChanges(MapKey map, Revision from, Revision to) {
  if (const absl::StatusOr<MapEntry> entry = Find(map); !entry.ok()) return entry.status();
  ChangeList changes;
  const std::string end = ChangeKey(map, to.Next());
  const rocksdb::Slice upper_bound(end);
  const std::unique_ptr<rocksdb::Iterator> scan = database_->Scan(Family::kChange, &upper_bound);
  // A commit names the one before it, so a list that is missing shows.
  Revision reached = from;
  for (scan->Seek(ChangeKey(map, from.Next())); scan->Valid(); scan->Next()) {
    const ValuePlace place{NameOf(Family::kChange), scan->key().ToStringView()};
    storage::v1::ChangeRecord record;
    absl::Status status = UnsealRecord(place, scan->value().ToStringView(), &record);
    if (!status.ok()) return status;
    if (!record.has_previous_revision() || record.previous_revision() != reached.value()) {
      return CompactedError(from, to);
    }
    const std::optional<std::uint64_t> revision = NumberOfKey(place.key);
    if (!revision) return DamagedValue(place, "is filed under no revision");
    reached = Revision(*revision);
    status = AddChanges(place, record, &changes);
    if (!status.ok()) return status;
  }
  if (!scan->status().ok()) return FromRocksdb(scan->status(), "reading change lists");
  if (reached != to) return CompactedError(from, to);
  SortUnique(&changes.objects);
  SortUnique(&changes.leaves);
  return changes;
}

}  // namespace steadymap
