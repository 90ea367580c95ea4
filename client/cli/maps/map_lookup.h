#pragma once

#include <chrono>

#include <absl/status/statusor.h>

#include "client/cli/text/command_context.h"
#include "core/types/identifiers.h"

#include "steadymap/v1/map.pb.h"

namespace steadymap {

/// What `--retry-for` says, in seconds, as the time to give up after.
std::chrono::milliseconds RetryTime(double retry_for_s);

/// The map as it is. While no server answers, asks again as uploads and watches do, for `retry_for`
/// in all, and says so once on `context->err`.
/// Errors: what a server answered; what the last try ended with.
absl::StatusOr<v1::Map> LookUpMap(const MapName& name,
                                  std::chrono::milliseconds retry_for,
                                  CommandContext* context);

}  // namespace steadymap
