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

/// The map and the session of an upload.
struct UploadTarget {
  std::shared_ptr<MapRuntime> map;
  SessionName session;
};

/// Finds the map and the session of an upload; the map may still be opening. Errors, with the
/// fields `map`, `robot`, `sensor` and `session`: `NotFound`; `InvalidArgument` with reason
/// `BAD_NAME`.
absl::StatusOr<UploadTarget> FindUploadTarget(const MapDirectory& maps,
                                              const std::string& map,
                                              const std::string& robot,
                                              const std::string& sensor,
                                              const std::string& session);

/// Returns the limits on an upload message. gRPC accepts slightly larger messages, so that the
/// client receives the server's error reason.
RequestLimits UploadRequestLimits(const LimitOptions& limits);

}  // namespace steadymap
