#pragma once

#include <memory>

#include <absl/status/statusor.h>

#include "core/map/map_snapshot.h"
#include "core/types/cancellation.h"
#include "server/rpc/message_stream.h"

#include "steadymap/v1/query_service.pb.h"

namespace steadymap {

/// Opens an export of the map as a file, in chunks of at most `kFilePieceBytes`. Each chunk is made
/// when it is requested; for a mesh format the whole mesh is computed first. Errors, of this
/// function and of the source: those of an invalid request; `NotFound` for an unknown object;
/// `Cancelled`.
absl::StatusOr<std::unique_ptr<MessageSource<v1::ExportMapResponse>>> OpenExport(
    std::shared_ptr<const MapSnapshot> snapshot,
    const v1::ExportMapRequest& request,
    const Cancellation& cancellation);

}  // namespace steadymap
