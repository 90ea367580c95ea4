#pragma once

#include <absl/status/statusor.h>

#include "core/map/map_filter.h"

#include "steadymap/v1/watch_service.pb.h"

/// Conversion between messages and core types: the filter of a watch. Pure functions, any thread.
namespace steadymap {

/// A filter. Errors: `InvalidArgument` with reason `BAD_VALUE` for too many values in a field,
/// classes out of range, unknown kinds, and those of `v1::Box`. Field paths are relative to the
/// message.
absl::StatusOr<MapFilter> FromProto(const v1::WatchFilter& message);

/// The message of a filter; equal filters give equal messages. The filter must select at least one
/// kind (asserted).
v1::WatchFilter ToProto(const MapFilter& filter);

}  // namespace steadymap
