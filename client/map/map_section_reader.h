#pragma once

#include <absl/status/statusor.h>
#include <grpcpp/support/sync_stream.h>

#include "core/map/map_snapshot.h"

#include "steadymap/v1/query_service.pb.h"

namespace steadymap {

/// Reads the stream of `GetMapSection` to its end or to the first error; `MapClient` documents the
/// errors. Blocks; one thread per stream.
absl::StatusOr<MapSnapshot> ReadMapSection(
    grpc::ClientReaderInterface<v1::GetMapSectionResponse>* stream);

}  // namespace steadymap
