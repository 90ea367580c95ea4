#pragma once

#include <chrono>

#include <absl/status/statusor.h>

#include "client/cli/text/command_context.h"
#include "core/types/identifiers.h"

#include "steadymap/v1/map.pb.h"

namespace steadymap {

/// Converts the value of `--retry-for`, in seconds, to the time after which retries end.
std::chrono::milliseconds RetryTime(double retry_for_s);

/// Returns the map. While no server responds, retries for `retry_for` in total with the back-off of
/// uploads and watches, and writes one message to `context->err`. Errors: the error from the
/// server; the error of the last attempt.
absl::StatusOr<v1::Map> LookUpMap(const MapName& name,
                                  std::chrono::milliseconds retry_for,
                                  CommandContext* context);

}  // namespace steadymap
