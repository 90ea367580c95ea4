// How a revision of a map is committed.

#include <algorithm>
#include <utility>

#include <absl/strings/str_cat.h>

#include "server/history_hash.h"
#include "server/map_database.h"
#include "server/object_records.h"
#include "server/robot_records.h"
#include "server/store_keys.h"
#include "server/store_records.h"

namespace steadymap {

absl::StatusOr<CommitMark> MapDatabase::Commit(const MapDelta& delta,
                                               const CommitDetails& details) {
  if (absl::Status status = state_->health(); !status.ok()) return status;
  const WriteTurn::Held turn(&commit_turn_);
  const Progress progress = this->progress();
  const storage::v1::Head& before = progress.head;
  if (delta.from.value() != before.revision() || delta.to < delta.from ||
      delta.to.value() > progress.durable_head.value()) {
    return absl::FailedPreconditionError(absl::StrCat("a commit from revision ",
                                                      delta.from.value(),
                                                      " to ",
                                                      delta.to.value(),
                                                      " does not fit map ",
                                                      record_.key.value(),
                                                      " at revision ",
                                                      before.revision(),
                                                      " with ",
                                                      progress.durable_head.value(),
                                                      " durable entries"));
  }
  if (delta.to == delta.from) return CommitMark{delta.from, before.history_hash()};
  // What is written now has to be written again when RocksDB's buffers are flushed.
  if (absl::Status status = CheckFree(surroundings_.options->write_buffer_bytes); !status.ok()) {
    return status;
  }
  storage::v1::Head head = before;
  head.set_revision(delta.to.value());
  head.set_last_capture_time_ns(delta.last_capture_time.nanoseconds());
  head.set_commits(before.commits() + 1);
  head.set_newest_object(delta.newest_object.value());
  head.set_events(before.events() + delta.events.size());
  head.set_uptime_ns(std::max<std::int64_t>(before.uptime_ns(), details.uptime.count()));
  rocksdb::WriteBatch batch;
  PutContent(delta, &batch);
  PutEvents(delta.events, EventNumber{before.events() + 1}, &batch);
  head.set_history_hash(ExtendHistory(before.history_hash(), delta.to, batch.Data()));
  for (const FramePose& pose : details.poses) {
    PutSealed(Family::kPose, PoseKey(pose.sequence), ToProto(pose), &batch);
  }
  if (delta.added_classes.size() != progress.stored_classes) {
    storage::v1::ClassTable table;
    for (const SemanticClass& row : delta.added_classes) *table.add_classes() = ToProto(row);
    PutSealed(Family::kMeta, ClassTableKey(), table, &batch);
  }
  PutChange(delta, before, head, &batch);
  PutProgress(progress, &head, &batch);
  if (absl::Status status = state_->Write(&batch); !status.ok()) return status;
  {
    const absl::MutexLock lock(&mutex_);
    progress_.stored_classes = delta.added_classes.size();
  }
  ForgetSaved(head);
  note_->NoteRevision(delta.to);
  return CommitMark{delta.to, head.history_hash()};
}

/// The database now knows `head`, and the sessions up to its group.
void MapDatabase::ForgetSaved(const storage::v1::Head& head) {
  const absl::MutexLock lock(&mutex_);
  progress_.head = head;
  std::erase_if(progress_.unsaved_sessions, [&head](const auto& unsaved) {
    return unsaved.second.group <= head.saved_group();
  });
}

void MapDatabase::PutProgress(const Progress& progress,
                              storage::v1::Head* head,
                              rocksdb::WriteBatch* batch) const {
  for (const auto& [name, unsaved] : progress.unsaved_sessions) {
    PutSealed(Family::kSession, SessionKey(name), ToProto(unsaved.record), batch);
  }
  head->set_durable_map_seq(progress.durable_head.value());
  head->set_saved_group(progress.group);
  PutSealed(Family::kMeta, HeadKey(), *head, batch);
}

void MapDatabase::PutSealed(Family family,
                            const std::string& key,
                            const google::protobuf::MessageLite& record,
                            rocksdb::WriteBatch* batch) const {
  batch->Put(state_->handle(family), key, Seal({NameOf(family), key}, record.SerializeAsString()));
}

void MapDatabase::PutChange(const MapDelta& delta,
                            const storage::v1::Head& before,
                            const storage::v1::Head& after,
                            rocksdb::WriteBatch* batch) const {
  storage::v1::ChangeRecord change;
  change.set_uptime_ns(after.uptime_ns());
  change.set_ordinal(after.commits());
  change.set_events(after.events());
  change.set_previous_revision(before.revision());
  change.set_previous_history_hash(before.history_hash());
  for (const LeafChange& leaf : delta.leaves) {
    change.mutable_leaf_keys()->append(PackLeafKey(leaf.key));
  }
  for (const ObjectChange& object : delta.objects) change.add_objects(object.id.value());
  PutSealed(Family::kChange, ChangeKey(delta.to), change, batch);
}

void MapDatabase::PutContent(const MapDelta& delta, rocksdb::WriteBatch* batch) const {
  for (const LeafChange& leaf : delta.leaves) {
    const std::string key = PackLeafKey(leaf.key);
    if (leaf.packed.empty()) {
      batch->Delete(state_->handle(Family::kLeaf), key);
      continue;
    }
    storage::v1::LeafRecord record;
    record.set_revision(delta.to.value());
    record.set_packed(leaf.packed);
    PutSealed(Family::kLeaf, key, record, batch);
  }
  for (const ObjectChange& object : delta.objects) {
    const std::string key = ObjectKey(object.id);
    if (!object.state.has_value()) {
      batch->Delete(state_->handle(Family::kObject), key);
      continue;
    }
    storage::v1::ObjectRecord record;
    record.set_revision(delta.to.value());
    *record.mutable_state() = ToProto(*object.state);
    PutSealed(Family::kObject, key, record, batch);
  }
  for (const FreeBlockChange& block : delta.free_blocks) {
    PutSealed(Family::kFree, FreeBlockKey(block.origin), ToProto(block.cells), batch);
  }
  for (const RobotChange& robot : delta.robots) {
    const std::string key = RobotKey(robot.sensor);
    if (robot.state.has_value()) {
      PutSealed(Family::kRobot, key, ToProto(*robot.state), batch);
    } else {
      batch->Delete(state_->handle(Family::kRobot), key);
    }
  }
}

void MapDatabase::PutEvents(const std::vector<ObjectEvent>& events,
                            EventNumber first,
                            rocksdb::WriteBatch* batch) const {
  EventNumber number = first;
  for (const ObjectEvent& event : events) {
    PutSealed(Family::kEvent, EventKey(number), ToProto(event), batch);
    number = number.Next();
  }
}

}  // namespace steadymap
