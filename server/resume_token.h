#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include <absl/status/statusor.h>

#include "core/identifiers.h"
#include "server/store.h"

#include "steadymap/v1/watch_service.pb.h"

namespace steadymap {

/// What a resume token is good for.
struct WatchScope {
  MapKey map;
  std::string incarnation;   ///< Of the map.
  std::uint64_t filter = 0;  ///< As `FingerprintOf` the filter.

  friend bool operator==(const WatchScope&, const WatchScope&) = default;
};

/// What a watcher has: everything up to here that passes its filter.
struct WatchPosition {
  Revision revision;
  EventNumber last_event;
  std::uint64_t history_hash = 0;  ///< As in `CommitMark`.

  CommitMark commit() const { return {revision, history_hash}; }

  friend bool operator==(const WatchPosition&, const WatchPosition&) = default;
};

/// Equal for filters that are equal field by field, and for hardly any others.
std::uint64_t FingerprintOf(const v1::WatchFilter& filter);

/// An opaque token for going on at a position.
std::string MakeResumeToken(const WatchScope& scope, const WatchPosition& position);

/// The position in a token.
/// Errors: `InvalidArgument` with reason `BAD_RESUME_TOKEN` and the field `resume_token` for
/// anything that `MakeResumeToken` did not make, with the field `filter` for a token of another
/// filter; `OutOfRange` with reason `REVISION_COMPACTED` for a token of another map or of an
/// incarnation that is no more.
absl::StatusOr<WatchPosition> ReadResumeToken(const WatchScope& scope, std::string_view token);

}  // namespace steadymap
