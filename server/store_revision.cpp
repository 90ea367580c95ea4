// The volume side of RocksStore: commits going in, the committed state coming out.

#include <algorithm>
#include <utility>

#include <absl/strings/str_cat.h>
#include <rocksdb/snapshot.h>

#include "core/error.h"
#include "core/tsdf_codec.h"
#include "server/rocks_store.h"
#include "server/store_keys.h"
#include "server/store_records.h"

namespace steadymap {
namespace {

// Names the map in an error that so far names a key only.
absl::Status OfMap(const MapRecord& record, const absl::Status& status) {
  return MakeError(
      status.code(),
      ReasonOf(status),
      absl::StrCat("map ", record.name.ToString(), ": ", std::string(status.message())));
}

absl::Status LoadLeaf(const ValuePlace& place, std::string_view value, MapSnapshot* snapshot) {
  const std::optional<LeafKey> key = LeafOfStoreKey(place.key);
  if (!key) return DamagedValue(place, "is filed under no leaf");
  storage::v1::LeafRecord leaf;
  if (absl::Status status = UnsealRecord(place, value, &leaf); !status.ok()) return status;
  LeafVoxels voxels;
  if (absl::Status status = UnpackLeaf(leaf.packed(), snapshot->scale, &voxels); !status.ok()) {
    return DamagedValue(place, std::string("is no leaf: ") + std::string(status.message()));
  }
  snapshot->background.MutableTile(key->origin).StoreLeaf(key->origin, voxels);
  return absl::OkStatus();
}

absl::StatusOr<SessionRecord> LoadSession(const ValuePlace& place, std::string_view value) {
  storage::v1::SessionRecord proto;
  if (absl::Status status = UnsealRecord(place, value, &proto); !status.ok()) return status;
  return FromProto(proto);
}

}  // namespace

absl::StatusOr<StoredState> RocksStore::LoadMap(const MapRecord& record) {
  if (absl::Status status = Find(record.key).status(); !status.ok()) return status;
  rocksdb::ManagedSnapshot snapshot(&database_->database());
  const absl::StatusOr<MapEntry> entry = LoadEntry(record.key, snapshot.snapshot());
  if (!entry.ok()) return OfMap(record, entry.status());
  StoredState state;
  state.durable_head = MapSequence{entry->log_head.durable_map_seq()};
  const MapConfig& config = entry->record.config;
  state.snapshot = MapSnapshot({config.voxel_size_m, config.truncation_m});
  state.snapshot.revision = Revision{entry->revision_head.revision()};
  state.snapshot.last_capture_time =
      Timestamp::FromNanoseconds(entry->revision_head.last_capture_time_ns());
  if (absl::Status status = LoadSessions(record.key, snapshot.snapshot(), &state); !status.ok()) {
    return OfMap(record, status);
  }
  if (absl::Status status = LoadLeaves(record.key, snapshot.snapshot(), &state); !status.ok()) {
    return OfMap(record, status);
  }
  return state;
}

absl::Status RocksStore::LoadSessions(MapKey map,
                                      const rocksdb::Snapshot* snapshot,
                                      StoredState* state) const {
  const KeyRange range = MapRange(map);
  const rocksdb::Slice upper_bound(range.end);
  const std::unique_ptr<rocksdb::Iterator> scan =
      database_->Scan(Family::kDedup, &upper_bound, snapshot);
  for (scan->Seek(range.begin); scan->Valid(); scan->Next()) {
    const ValuePlace place{NameOf(Family::kDedup), scan->key().ToStringView()};
    absl::StatusOr<SessionRecord> session = LoadSession(place, scan->value().ToStringView());
    if (!session.ok()) return session.status();
    state->sessions.push_back(*std::move(session));
  }
  return FromRocksdb(scan->status(), "reading upload sessions");
}

absl::Status RocksStore::LoadLeaves(MapKey map,
                                    const rocksdb::Snapshot* snapshot,
                                    StoredState* state) const {
  const KeyRange range = MapRange(map);
  const rocksdb::Slice upper_bound(range.end);
  const std::unique_ptr<rocksdb::Iterator> scan =
      database_->Scan(Family::kLeaf, &upper_bound, snapshot);
  for (scan->Seek(range.begin); scan->Valid(); scan->Next()) {
    const ValuePlace place{NameOf(Family::kLeaf), scan->key().ToStringView()};
    if (absl::Status status = LoadLeaf(place, scan->value().ToStringView(), &state->snapshot);
        !status.ok()) {
      return status;
    }
  }
  return FromRocksdb(scan->status(), "reading leaves");
}

absl::Status RocksStore::CommitRevision(MapKey map, const MapDelta& delta, Timestamp now) {
  if (absl::Status status = database_->health(); !status.ok()) return status;
  const WriteTurns::Turn turn(&commit_turns_, {map});
  const absl::StatusOr<MapEntry> entry = Find(map);
  if (!entry.ok()) return entry.status();
  storage::v1::RevisionHead head = entry->revision_head;
  if (delta.from.value() != head.revision() || delta.to < delta.from ||
      delta.to.value() > entry->log_head.durable_map_seq()) {
    return absl::FailedPreconditionError(absl::StrCat("a commit from revision ",
                                                      delta.from.value(),
                                                      " to ",
                                                      delta.to.value(),
                                                      " does not fit map ",
                                                      map.value(),
                                                      " at revision ",
                                                      head.revision(),
                                                      " with ",
                                                      entry->log_head.durable_map_seq(),
                                                      " durable frames"));
  }
  if (delta.to == delta.from) return absl::OkStatus();
  head.set_revision(delta.to.value());
  head.set_last_capture_time_ns(delta.last_capture_time.nanoseconds());
  head.set_commits(head.commits() + 1);
  head.set_commit_time_ns(std::max(head.commit_time_ns(), now.nanoseconds()));
  rocksdb::WriteBatch batch;
  PutCommit(map, delta, head, &batch);
  if (absl::Status status = database_->Write(&batch); !status.ok()) return status;
  const absl::MutexLock lock(&mutex_);
  entries_.at(map).revision_head = std::move(head);
  return absl::OkStatus();
}

void RocksStore::PutCommit(MapKey map,
                           const MapDelta& delta,
                           const storage::v1::RevisionHead& head,
                           rocksdb::WriteBatch* batch) const {
  storage::v1::ChangeRecord change;
  change.set_commit_time_ns(head.commit_time_ns());
  change.set_ordinal(head.commits());
  for (const LeafChange& leaf : delta.leaves) {
    const std::string key = LeafStoreKey(map, leaf.key);
    change.mutable_leaf_keys()->append(PackLeafKey(leaf.key));
    if (leaf.packed.empty()) {
      batch->Delete(database_->handle(Family::kLeaf), key);
      continue;
    }
    storage::v1::LeafRecord record;
    record.set_revision(delta.to.value());
    record.set_packed(leaf.packed);
    batch->Put(
        database_->handle(Family::kLeaf), key, SealRecord({NameOf(Family::kLeaf), key}, record));
  }
  const std::string change_key = ChangeKey(map, delta.to);
  batch->Put(database_->handle(Family::kChange),
             change_key,
             SealRecord({NameOf(Family::kChange), change_key}, change));
  const std::string head_key = RevisionHeadKey(map);
  batch->Put(database_->handle(Family::kMeta),
             head_key,
             SealRecord({NameOf(Family::kMeta), head_key}, head));
}

}  // namespace steadymap
