#pragma once

#include <absl/status/status.h>
#include <rocksdb/write_batch.h>

#include "server/store/database/state_database.h"
#include "server/store/model/store.h"

#include "steadymap/storage/v1/records.pb.h"

/// Retention of a map's history. Each function adds the deletion of records beyond their retention
/// to `batch`. Errors: as `state_reading.h`.
namespace steadymap {

/// Deletes poses beyond the newest `StoreOptions::kept_poses`.
absl::Status TrimPoses(const StateDatabase& state,
                       const StoreOptions& options,
                       const storage::v1::Head& head,
                       rocksdb::WriteBatch* batch);

/// Deletes change lists that are too old or too many, except those that a live watcher still needs.
absl::Status TrimChangeLists(const StateDatabase& state,
                             const StoreOptions& options,
                             const storage::v1::Head& head,
                             const TrimBounds& bounds,
                             rocksdb::WriteBatch* batch);

/// Deletes events beyond the newest `StoreOptions::kept_events`.
absl::Status TrimEvents(const StateDatabase& state,
                        const StoreOptions& options,
                        const storage::v1::Head& head,
                        rocksdb::WriteBatch* batch);

/// True if `session` has been idle for longer than `bounds` allows.
bool IsIdle(const SessionRecord& session, const TrimBounds& bounds);

/// Deletes idle sessions.
absl::Status TrimSessions(const StateDatabase& state,
                          const TrimBounds& bounds,
                          rocksdb::WriteBatch* batch);

}  // namespace steadymap
