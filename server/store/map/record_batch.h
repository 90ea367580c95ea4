#pragma once

#include <string>
#include <vector>

#include <rocksdb/write_batch.h>

#include "core/map/map_delta.h"
#include "server/store/database/state_database.h"
#include "server/store/model/store.h"

#include "steadymap/storage/v1/records.pb.h"

namespace steadymap {

/// One atomic write to a map's database. Each record is stored under its key and sealed with its
/// checksum. One thread at a time.
class RecordBatch {
 public:
  explicit RecordBatch(const StateDatabase& state) : state_(state) {}

  /// Adds the leaves, objects, free space and robots of a commit.
  void PutContent(const MapDelta& delta);

  /// Adds events, numbered from `first`.
  void PutEvents(const std::vector<ObjectEvent>& events, EventNumber first);

  void PutPoses(const std::vector<FramePose>& poses);

  /// Replaces the list of classes that were added after the map's creation.
  void PutAddedClasses(const std::vector<SemanticClass>& classes);

  /// Adds the change list of the commit from the head `before` to the head `after`.
  void PutChange(const MapDelta& delta,
                 const storage::v1::Head& before,
                 const storage::v1::Head& after);

  void PutSession(const SessionRecord& session);
  void PutHead(const storage::v1::Head& head);

  rocksdb::WriteBatch& batch() { return batch_; }

 private:
  void Put(Family family, const std::string& key, const google::protobuf::MessageLite& record);

  const StateDatabase& state_;
  rocksdb::WriteBatch batch_;
};

}  // namespace steadymap
