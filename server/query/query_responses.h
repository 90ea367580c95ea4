#pragma once

#include <cstdint>

#include <absl/status/status.h>

#include "core/geometry/geometry.h"
#include "core/map/map_snapshot.h"
#include "core/types/cancellation.h"
#include "server/store/model/store.h"

#include "steadymap/v1/query_service.pb.h"

/// What the queries answer, as functions of one snapshot. Requests are checked here; field paths
/// are those of the request. Any thread.
namespace steadymap {

/// Steps (`QueryWork`) that one call may take: some 15 s of a core. 100 000 rays of 30 m through a
/// hall of 1 184 objects at 5 cm take 9 million.
inline constexpr std::uint64_t kMaxQuerySteps = 50'000'000;

/// Distances at points. Cost: as `MapSampler`. Errors, here and below: also `Cancelled`, as
/// `cancellation` says, and `ResourceExhausted` with reason `WORK_LIMIT` beyond `max_steps`.
absl::Status AnswerSampleDistance(const MapSnapshot& snapshot,
                                  const v1::SampleDistanceRequest& request,
                                  const Cancellation& cancellation,
                                  v1::SampleDistanceResponse* response,
                                  std::uint64_t max_steps = kMaxQuerySteps);

/// Surfaces along rays.
absl::Status AnswerCastRays(const MapSnapshot& snapshot,
                            const v1::CastRaysRequest& request,
                            const Cancellation& cancellation,
                            v1::CastRaysResponse* response,
                            std::uint64_t max_steps = kMaxQuerySteps);

/// A page of the poses of a map's frames up to the snapshot's revision, read from `store`.
absl::Status AnswerListFramePoses(Store& store,
                                  MapKey map,
                                  const MapSnapshot& snapshot,
                                  const v1::ListFramePosesRequest& request,
                                  const Cancellation& cancellation,
                                  v1::ListFramePosesResponse* response);

}  // namespace steadymap
