#pragma once

#include <memory>

#include <absl/status/statusor.h>

#include "core/map/map_snapshot.h"
#include "core/types/cancellation.h"
#include "server/rpc/message_stream.h"

#include "steadymap/v1/query_service.pb.h"

namespace steadymap {

/// Opens a stream of the objects and leaves that touch the box of the request, in messages of at
/// most about 1 MiB. Errors, of this function and of the source: those of an invalid request;
/// `NotFound` for an unknown object; `Cancelled`.
absl::StatusOr<std::unique_ptr<MessageSource<v1::GetMapSectionResponse>>> OpenMapSection(
    std::shared_ptr<const MapSnapshot> snapshot,
    const v1::GetMapSectionRequest& request,
    const Cancellation& cancellation);

}  // namespace steadymap
