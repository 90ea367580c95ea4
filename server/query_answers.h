#pragma once

#include <memory>
#include <optional>
#include <string>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "core/cancellation.h"
#include "core/geometry.h"
#include "core/map_snapshot.h"
#include "server/map_runtime.h"
#include "server/message_stream.h"

#include "steadymap/v1/query_service.pb.h"

/// What the queries answer, as functions of one snapshot. Requests are checked here; field paths
/// are those of the request. Any thread.
namespace steadymap {

/// Distances at points. Cost: as `MapSampler`.
absl::Status AnswerSampleDistance(const MapSnapshot& snapshot,
                                  const v1::SampleDistanceRequest& request,
                                  v1::SampleDistanceResponse* response);

/// Surfaces along rays.
absl::Status AnswerCastRays(const MapSnapshot& snapshot,
                            const v1::CastRaysRequest& request,
                            v1::CastRaysResponse* response);

/// Poses of the frames of `map` up to the snapshot's revision, read from `store`.
absl::Status AnswerListFramePoses(Store& store,
                                  const MapRuntime& map,
                                  const v1::ListFramePosesRequest& request,
                                  v1::ListFramePosesResponse* response);

/// The objects and leaves that touch the request's box, in messages of at most about 1 MiB.
/// Errors, here and of the source: also `Cancelled`, as `cancellation` says.
absl::StatusOr<std::unique_ptr<MessageSource<v1::GetMapSectionResponse>>> OpenMapSection(
    std::shared_ptr<const MapSnapshot> snapshot,
    const v1::GetMapSectionRequest& request,
    const Cancellation& cancellation);

/// The map as a file, in chunks of at most `kFilePieceBytes`, each made when it is asked for; of a
/// mesh file the mesh is made first. Errors, here and of the source: also `Cancelled`, as
/// `cancellation` says.
absl::StatusOr<std::unique_ptr<MessageSource<v1::ExportMapResponse>>> OpenExport(
    std::shared_ptr<const MapSnapshot> snapshot,
    const v1::ExportMapRequest& request,
    const Cancellation& cancellation);

}  // namespace steadymap
