// How RocksStore commits a revision.

#include <algorithm>
#include <utility>

#include <absl/strings/str_cat.h>

#include "server/object_records.h"
#include "server/robot_records.h"
#include "server/rocks_store.h"
#include "server/store_keys.h"
#include "server/store_records.h"

namespace steadymap {

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
  head.set_newest_object(delta.newest_object.value());
  const EventNumber first_event{head.events() + 1};
  head.set_events(head.events() + delta.events.size());
  rocksdb::WriteBatch batch;
  PutCommit(map, delta, head, &batch);
  PutEvents(map, delta.events, first_event, &batch);
  if (absl::Status status = database_->Write(&batch); !status.ok()) return status;
  const absl::MutexLock lock(&mutex_);
  entries_.at(map).revision_head = std::move(head);
  return absl::OkStatus();
}

void RocksStore::PutSealed(Family family,
                           const std::string& key,
                           const google::protobuf::MessageLite& record,
                           rocksdb::WriteBatch* batch) const {
  batch->Put(
      database_->handle(family), key, Seal({NameOf(family), key}, record.SerializeAsString()));
}

void RocksStore::PutCommit(MapKey map,
                           const MapDelta& delta,
                           const storage::v1::RevisionHead& head,
                           rocksdb::WriteBatch* batch) const {
  storage::v1::ChangeRecord change;
  change.set_commit_time_ns(head.commit_time_ns());
  change.set_ordinal(head.commits());
  change.set_events(head.events());
  change.set_previous_revision(delta.from.value());
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
    PutSealed(Family::kLeaf, key, record, batch);
  }
  for (const ObjectChange& object : delta.objects) {
    const std::string key = ObjectKey(map, object.id);
    change.add_objects(object.id.value());
    if (!object.state.has_value()) {
      batch->Delete(database_->handle(Family::kObject), key);
      continue;
    }
    storage::v1::ObjectRecord record;
    record.set_revision(delta.to.value());
    *record.mutable_state() = ToProto(*object.state);
    PutSealed(Family::kObject, key, record, batch);
  }
  for (const FreeBlockChange& block : delta.free_blocks) {
    PutSealed(Family::kFree, FreeBlockKey(map, block.origin), ToProto(block.cells), batch);
  }
  for (const RobotChange& robot : delta.robots) {
    const std::string key = RobotKey(map, robot.robot);
    if (robot.state.has_value()) {
      PutSealed(Family::kRobot, key, ToProto(*robot.state), batch);
    } else {
      batch->Delete(database_->handle(Family::kRobot), key);
    }
  }
  PutSealed(Family::kChange, ChangeKey(map, delta.to), change, batch);
  PutSealed(Family::kMeta, RevisionHeadKey(map), head, batch);
}

void RocksStore::PutEvents(MapKey map,
                           const std::vector<ObjectEvent>& events,
                           EventNumber first,
                           rocksdb::WriteBatch* batch) const {
  EventNumber number = first;
  for (const ObjectEvent& event : events) {
    PutSealed(Family::kEvent, EventKey(map, number), ToProto(event), batch);
    number = number.Next();
  }
}

}  // namespace steadymap
