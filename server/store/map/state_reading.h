#pragma once

#include <functional>
#include <string_view>
#include <vector>

#include <absl/status/status.h>
#include <rocksdb/snapshot.h>

#include "core/types/map_config.h"
#include "server/store/database/state_database.h"
#include "server/store/database/store_records.h"
#include "server/store/model/store.h"

#include "steadymap/storage/v1/records.pb.h"

/// Reads single records of a map's database. Every function reads from `snapshot`; null: the newest
/// state. Thread-safe. Errors: `DataLoss` with reason `CHECKSUM` and the key of the damaged value
/// in the message.
namespace steadymap {

/// Calls `visit` for every record of a family in key order, until it returns an error, which is
/// returned.
absl::Status ForEachRecord(
    const StateDatabase& state,
    Family family,
    const rocksdb::Snapshot* snapshot,
    const std::function<absl::Status(const ValuePlace&, std::string_view)>& visit);

/// Reads the head: the progress of the map.
absl::Status ReadHead(const StateDatabase& state,
                      const rocksdb::Snapshot* snapshot,
                      storage::v1::Head* head);

/// Appends the classes that were added after the map's creation to `classes`.
absl::Status ReadAddedClasses(const StateDatabase& state,
                              const rocksdb::Snapshot* snapshot,
                              std::vector<SemanticClass>* classes);

/// Appends the sessions to `sessions`, in key order.
absl::Status ReadSessions(const StateDatabase& state,
                          const rocksdb::Snapshot* snapshot,
                          std::vector<SessionRecord>* sessions);

}  // namespace steadymap
