#include "server/store/map/record_batch.h"

#include "server/store/database/object_records.h"
#include "server/store/database/robot_records.h"
#include "server/store/database/store_keys.h"
#include "server/store/database/store_records.h"

namespace steadymap {

void RecordBatch::PutContent(const MapDelta& delta) {
  for (const LeafChange& leaf : delta.leaves) {
    const std::string key = PackLeafKey(leaf.key);
    if (leaf.packed.empty()) {
      batch_.Delete(state_.handle(Family::kLeaf), key);
      continue;
    }
    storage::v1::LeafRecord record;
    record.set_revision(delta.to.value());
    record.set_packed(leaf.packed);
    Put(Family::kLeaf, key, record);
  }
  for (const ObjectChange& object : delta.objects) {
    const std::string key = ObjectKey(object.id);
    if (!object.state.has_value()) {
      batch_.Delete(state_.handle(Family::kObject), key);
      continue;
    }
    storage::v1::ObjectRecord record;
    record.set_revision(delta.to.value());
    *record.mutable_state() = ToProto(*object.state);
    Put(Family::kObject, key, record);
  }
  for (const FreeBlockChange& change : delta.free_blocks) {
    Put(Family::kFree, FreeBlockKey(change.origin), ToProto(change.block));
  }
  for (const RobotChange& robot : delta.robots) {
    const std::string key = RobotKey(robot.sensor);
    if (robot.state.has_value()) {
      Put(Family::kRobot, key, ToProto(*robot.state));
    } else {
      batch_.Delete(state_.handle(Family::kRobot), key);
    }
  }
}

void RecordBatch::PutEvents(const std::vector<ObjectEvent>& events, EventNumber first) {
  EventNumber number = first;
  for (const ObjectEvent& event : events) {
    Put(Family::kEvent, EventKey(number), ToProto(event));
    number = number.Next();
  }
}

void RecordBatch::PutPoses(const std::vector<FramePose>& poses) {
  for (const FramePose& pose : poses) Put(Family::kPose, PoseKey(pose.sequence), ToProto(pose));
}

void RecordBatch::PutAddedClasses(const std::vector<SemanticClass>& classes) {
  storage::v1::ClassTable table;
  for (const SemanticClass& row : classes) *table.add_classes() = ToProto(row);
  Put(Family::kMeta, ClassTableKey(), table);
}

void RecordBatch::PutChange(const MapDelta& delta,
                            const storage::v1::Head& before,
                            const storage::v1::Head& after) {
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
  Put(Family::kChange, ChangeKey(delta.to), change);
}

void RecordBatch::PutSession(const SessionRecord& session) {
  Put(Family::kSession, SessionKey(session.name), ToProto(session));
}

void RecordBatch::PutHead(const storage::v1::Head& head) { Put(Family::kMeta, HeadKey(), head); }

void RecordBatch::Put(Family family,
                      const std::string& key,
                      const google::protobuf::MessageLite& record) {
  batch_.Put(state_.handle(family), key, SealRecord({NameOf(family), key}, record));
}

}  // namespace steadymap
