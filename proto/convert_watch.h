#pragma once

#include <absl/status/statusor.h>

#include "core/map/map_filter.h"

#include "steadymap/v1/watch_service.pb.h"

/// The border between the wire and core: what a watcher wants to see. Pure functions, any thread.
namespace steadymap {

/// Errors: `InvalidArgument` with reason `BAD_VALUE` for more values than the field may name,
/// classes out of range, unknown kinds, and as for `v1::Box`. Field paths are relative to the
/// message.
absl::StatusOr<MapFilter> FromProto(const v1::WatchFilter& message);

/// Equal filters give equal messages. A filter that wants no kind at all cannot be written
/// (asserted).
v1::WatchFilter ToProto(const MapFilter& filter);

}  // namespace steadymap
