#pragma once

#include <memory>

#include <absl/status/statusor.h>

#include "core/map/map_snapshot.h"
#include "core/types/cancellation.h"
#include "server/rpc/message_stream.h"

#include "steadymap/v1/query_service.pb.h"

namespace steadymap {

/// The map as a file, in chunks of at most `kFilePieceBytes`, each made when it is asked for; of a
/// mesh file the mesh is made first. Errors, here and of the source: also `Cancelled`, as
/// `cancellation` says.
absl::StatusOr<std::unique_ptr<MessageSource<v1::ExportMapResponse>>> OpenExport(
    std::shared_ptr<const MapSnapshot> snapshot,
    const v1::ExportMapRequest& request,
    const Cancellation& cancellation);

}  // namespace steadymap
