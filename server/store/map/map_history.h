#pragma once

#include <cstddef>
#include <vector>

#include <absl/status/statusor.h>

#include "server/store/database/state_database.h"
#include "server/store/model/store.h"

/// Reads the history of a map from its database: changes, events, poses. `Store` documents each
/// function. Thread-safe.
namespace steadymap {

absl::StatusOr<ChangeList> ReadChanges(const StateDatabase& state, CommitMark from, Revision to);

absl::StatusOr<std::vector<StoredEvent>> ReadEvents(const StateDatabase& state,
                                                    EventNumber first,
                                                    std::size_t limit);

absl::StatusOr<std::vector<FramePose>> ReadPoses(const StateDatabase& state,
                                                 MapSequence first,
                                                 MapSequence last,
                                                 std::size_t limit);

}  // namespace steadymap
