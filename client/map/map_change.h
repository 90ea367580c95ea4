#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "client/transport/backoff.h"
#include "client/transport/channel.h"
#include "core/types/identifiers.h"

#include "steadymap/v1/map.pb.h"

namespace steadymap {

/// Changes to a map. Fields that are not named here keep their values.
struct MapChange {
  std::map<std::string, std::string> labels{};     ///< Added or overwritten.
  std::vector<std::string> removed_labels{};       ///< Keys; unknown keys are ignored.
  std::optional<std::string> world_description{};  ///< `v1::WorldFrame.description`.
  /// Rows for the class table. A row that the table already holds has no effect. The server refuses
  /// a row with the id of a different row, since rows are immutable.
  std::vector<v1::SemanticClass> classes{};
  /// Required etag of the map. Empty: any.
  std::string etag{};

  /// True if nothing is to be changed.
  bool is_empty() const {
    return labels.empty() && removed_labels.empty() && !world_description && classes.empty();
  }
};

/// Options for retries after a lost response.
struct MapChangeOptions {
  BackoffOptions backoff{.give_up_after = std::chrono::seconds(10)};

  /// Replaces the wait between two attempts and the clock. For tests. Empty: waits in real time.
  std::function<void(std::chrono::milliseconds)> sleep{};
};

/// Reads a map, applies `change` and returns the changed map.
///
/// The change applies to the state that was read. If another client changes the map in between, the
/// map is read again, unless `change.etag` requires a certain state. After a lost response the same
/// request is sent again with its request id and takes effect once. Each attempt uses a new channel
/// from `open_channel`. Errors: `InvalidArgument` for an empty change or values that the server
/// rejects; `Aborted` with reason `ETAG_MISMATCH`; `NotFound`; the error of the last attempt.
absl::StatusOr<v1::Map> ChangeMap(const ChannelOpener& open_channel,
                                  const MapName& name,
                                  const MapChange& change,
                                  const MapChangeOptions& options = {});

}  // namespace steadymap
