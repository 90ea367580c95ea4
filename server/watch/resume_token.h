#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "core/map/map_filter.h"
#include "core/types/identifiers.h"
#include "server/store/model/store.h"

namespace steadymap {

/// The watch for which a resume token is valid.
struct WatchScope {
  MapKey map;
  std::string map_name;      ///< Full name.
  std::string incarnation;   ///< Incarnation of the map.
  std::uint64_t filter = 0;  ///< `FingerprintOf` the filter.

  friend bool operator==(const WatchScope&, const WatchScope&) = default;
};

/// The position of a watcher: it has all data up to here that passes its filter.
struct WatchPosition {
  Revision revision;
  EventNumber last_event;
  std::uint64_t history_hash = 0;  ///< See `CommitMark`.
  /// True if the watcher also has the leaves from before the start of the watch; false after a
  /// start with WATCH_START_NOW.
  bool has_leaves = true;

  CommitMark commit() const { return {revision, history_hash}; }

  friend bool operator==(const WatchPosition&, const WatchPosition&) = default;
};

/// Returns a hash that is equal for filters that accept the same data, independent of the order and
/// repetition of their lists, and different for most other filters.
std::uint64_t FingerprintOf(const MapFilter& filter);

/// Identifies the content of a step: two steps with equal keys have the same messages in the same
/// order.
struct StepKey {
  WatchScope scope;
  WatchPosition before;  ///< Empty for a snapshot.
  CommitMark to;
  std::size_t max_message_bytes = 0;
  bool takes_patches = false;
  bool as_snapshot = false;
  bool is_shown_known = false;  ///< Objects shown at `before` are known.

  friend bool operator==(const StepKey&, const StepKey&) = default;
};

/// Makes an opaque token to resume at a position.
std::string MakeResumeToken(const WatchScope& scope, const WatchPosition& position);

/// Makes an opaque token for a watcher that has the messages of a step before the index `place`.
std::string MakeStepToken(const StepKey& step, std::size_t place);

/// The content of a resume token.
struct ResumeToken {
  WatchPosition position;
  /// If the token fits the scope: the step of which the watcher has a part; none between two steps.
  std::optional<StepKey> step;
  std::size_t place = 0;  ///< Index in `step` of the first message that the watcher does not have.
  /// OK if the token was made for the scope. Otherwise the reason for which the position cannot be
  /// used: `InvalidArgument` with reason `BAD_RESUME_TOKEN` and the field `resume_token` for
  /// another map, with the field `filter` for another filter; `OutOfRange` with reason
  /// `REVISION_COMPACTED` if the history of the map was replaced.
  absl::Status fit;
};

/// Parses a token. Errors: `InvalidArgument` with reason `BAD_RESUME_TOKEN` and the field
/// `resume_token` for a token that this service did not make.
absl::StatusOr<ResumeToken> ReadResumeToken(const WatchScope& scope, std::string_view token);

}  // namespace steadymap
