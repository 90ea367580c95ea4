#pragma once

#include <cstdint>

#include <absl/status/status.h>

#include "core/geometry/geometry.h"
#include "core/map/map_snapshot.h"
#include "core/types/cancellation.h"
#include "server/store/model/store.h"

#include "steadymap/v1/query_service.pb.h"

/// Responses to queries, as functions of one snapshot. The functions check the request; field paths
/// in errors are relative to it. Thread-safe.
namespace steadymap {

/// Limit of steps (`QueryWork`) for one call: about 15 s on one core. 100 000 rays of 30 m through
/// a hall of 1 184 objects at 5 cm take 9 million steps.
inline constexpr std::uint64_t kMaxQuerySteps = 50'000'000;

/// Samples distances at points. Cost: that of `MapSampler`. Errors: those of an invalid request;
/// `Cancelled`; `ResourceExhausted` with reason `WORK_LIMIT` after `max_steps`.
absl::Status AnswerSampleDistance(const MapSnapshot& snapshot,
                                  const v1::SampleDistanceRequest& request,
                                  const Cancellation& cancellation,
                                  v1::SampleDistanceResponse* response,
                                  std::uint64_t max_steps = kMaxQuerySteps);

/// Finds the surfaces along rays by ray casting. Cost: that of `MapSampler`. Errors: those of an
/// invalid request; `Cancelled`; `ResourceExhausted` with reason `WORK_LIMIT` after `max_steps`.
absl::Status AnswerCastRays(const MapSnapshot& snapshot,
                            const v1::CastRaysRequest& request,
                            const Cancellation& cancellation,
                            v1::CastRaysResponse* response,
                            std::uint64_t max_steps = kMaxQuerySteps);

/// Lists the robots that a snapshot knows.
absl::Status AnswerListRobots(const MapSnapshot& snapshot, v1::ListRobotsResponse* response);

/// Fills a page with the poses of a map's frames up to the revision of the snapshot, read from
/// `store`. Errors: those of an invalid request; `Cancelled`; those of the store.
absl::Status AnswerListFramePoses(Store& store,
                                  MapKey map,
                                  const MapSnapshot& snapshot,
                                  const v1::ListFramePosesRequest& request,
                                  const Cancellation& cancellation,
                                  v1::ListFramePosesResponse* response);

}  // namespace steadymap
