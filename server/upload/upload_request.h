#pragma once

#include <memory>
#include <string>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "server/config/server_config.h"
#include "server/mapping/map_directory.h"
#include "server/mapping/map_runtime.h"
#include "server/rpc/request_reader.h"

namespace steadymap {

/// What an upload names: a map and a session in it.
struct UploadTarget {
  std::shared_ptr<MapRuntime> map;
  SessionName session;
};

/// Finds what an upload names; the map may still be opening. Errors, with the fields `map`,
/// `robot`, `sensor` and `session`: `NotFound`; `InvalidArgument` with reason `BAD_NAME`.
absl::StatusOr<UploadTarget> FindUploadTarget(const MapDirectory& maps,
                                              const std::string& map,
                                              const std::string& robot,
                                              const std::string& sensor,
                                              const std::string& session);

/// What a message of an upload may hold. gRPC itself lets a bit more in, so that the client hears
/// the reason.
RequestLimits UploadRequestLimits(const LimitOptions& limits);

}  // namespace steadymap
