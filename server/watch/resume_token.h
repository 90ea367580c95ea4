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

/// What a resume token is good for.
struct WatchScope {
  MapKey map;
  std::string map_name;      ///< In full.
  std::string incarnation;   ///< Of the map.
  std::uint64_t filter = 0;  ///< As `FingerprintOf` the filter.

  friend bool operator==(const WatchScope&, const WatchScope&) = default;
};

/// What a watcher has: everything up to here that passes its filter.
struct WatchPosition {
  Revision revision;
  EventNumber last_event;
  std::uint64_t history_hash = 0;  ///< As in `CommitMark`.
  /// Whether that includes the leaves from before the watch began; not if it began from now on.
  bool has_leaves = true;

  CommitMark commit() const { return {revision, history_hash}; }

  friend bool operator==(const WatchPosition&, const WatchPosition&) = default;
};

/// Equal for filters that let the same pass, whatever the order and the repetitions in their lists,
/// and for hardly any others.
std::uint64_t FingerprintOf(const MapFilter& filter);

/// What makes two steps the same: the same messages in the same order.
struct StepKey {
  WatchScope scope;
  WatchPosition before;  ///< Of a snapshot, nothing.
  CommitMark to;
  std::size_t max_message_bytes = 0;
  bool takes_patches = false;
  bool as_snapshot = false;
  bool is_shown_known = false;  ///< Whether it is known which objects were shown at `before`.

  friend bool operator==(const StepKey&, const StepKey&) = default;
};

/// An opaque token for going on at a position.
std::string MakeResumeToken(const WatchScope& scope, const WatchPosition& position);

/// One for a watcher who has the messages of a step up to the one at `place`, that one excluded.
std::string MakeStepToken(const StepKey& step, std::size_t place);

/// What a token says.
struct ResumeToken {
  WatchPosition position;
  /// Of the scope that was asked for: the step that the watcher has part of; none if it is between
  /// two steps.
  std::optional<StepKey> step;
  std::size_t place = 0;  ///< In that step: the first message that the watcher does not have.
  /// OK if the token was given to the scope. Otherwise why the position is of no use there:
  /// `InvalidArgument` with reason `BAD_RESUME_TOKEN` and the field `resume_token` for another map,
  /// with the field `filter` for another filter; `OutOfRange` with reason `REVISION_COMPACTED` for
  /// a history of the map that was replaced.
  absl::Status fit;
};

/// Errors: `InvalidArgument` with reason `BAD_RESUME_TOKEN` and the field `resume_token` for
/// anything that was not made here.
absl::StatusOr<ResumeToken> ReadResumeToken(const WatchScope& scope, std::string_view token);

}  // namespace steadymap
