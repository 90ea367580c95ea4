#pragma once

#include <memory>
#include <string>

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <google/protobuf/message_lite.h>

#include "server/map_directory.h"
#include "server/map_runtime.h"
#include "server/server_config.h"

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

/// OK if a message is no larger than the server takes. gRPC itself lets a bit more in, so that the
/// client hears the reason. Errors: `ResourceExhausted` with reason `MESSAGE_TOO_LARGE`.
absl::Status CheckMessageSize(const google::protobuf::MessageLite& message,
                              const LimitOptions& limits);

}  // namespace steadymap
