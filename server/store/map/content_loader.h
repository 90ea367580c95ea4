#pragma once

#include <absl/status/status.h>
#include <rocksdb/snapshot.h>

#include "core/map/map_snapshot.h"
#include "server/store/database/state_database.h"

namespace steadymap {

/// Reads the objects, leaves, free space and robots of a map's database into `content`, whose scale
/// must be set. `snapshot` null: reads the newest state. Leaves are unpacked on all cores. Cost: up
/// to 20 us per leaf. Errors: `DataLoss` with reason `CHECKSUM` and the key of the damaged value in
/// the message.
absl::Status LoadContent(const StateDatabase& state,
                         const rocksdb::Snapshot* snapshot,
                         MapSnapshot* content);

}  // namespace steadymap
