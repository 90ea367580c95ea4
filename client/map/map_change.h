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

/// What to change of a map. All that is not named here stays as it is.
struct MapChange {
  std::map<std::string, std::string> labels{};     ///< Added, or given another value.
  std::vector<std::string> removed_labels{};       ///< Keys; one that the map lacks is no error.
  std::optional<std::string> world_description{};  ///< For `v1::WorldFrame.description`.
  /// Rows for the class table. One that the table holds already changes nothing; one that has the
  /// id of another row is refused by the server, since rows cannot be changed.
  std::vector<v1::SemanticClass> classes{};
  /// The etag that the map must have. Empty: whichever it has.
  std::string etag{};

  /// Whether nothing is to be changed.
  bool is_empty() const {
    return labels.empty() && removed_labels.empty() && !world_description && classes.empty();
  }
};

/// How a change is sent again where its answer is lost.
struct MapChangeOptions {
  BackoffOptions backoff{.give_up_after = std::chrono::seconds(10)};

  /// Replaces the waiting between two tries, and the clock. For tests. Empty: really waits.
  std::function<void(std::chrono::milliseconds)> sleep{};
};

/// Reads a map, changes what `change` names and returns the map as it is then.
///
/// The change is made to the state that was read: where somebody else changes the map in between,
/// it is read again, unless `change.etag` names the only state that may be changed. Where the
/// answer is lost on its way the same request is sent again, with its request id, and counts once.
/// Each try has a channel of its own from `open_channel`.
/// Errors: `InvalidArgument` for an empty change, and as the server finds the new values; `Aborted`
/// with reason `ETAG_MISMATCH`; `NotFound`; what the last try ended with.
absl::StatusOr<v1::Map> ChangeMap(const ChannelOpener& open_channel,
                                  const MapName& name,
                                  const MapChange& change,
                                  const MapChangeOptions& options = {});

}  // namespace steadymap
