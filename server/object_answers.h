#pragma once

#include <absl/status/status.h>

#include "core/identifiers.h"
#include "core/map_snapshot.h"
#include "server/store.h"

#include "steadymap/v1/query_service.pb.h"

/// What the queries about objects and their history answer. Requests are checked here; field paths
/// are those of the request. Any thread.
namespace steadymap {

/// One object of the snapshot. Errors: `NotFound` with the field `object_id`.
absl::Status AnswerGetObject(const MapSnapshot& snapshot,
                             const v1::GetObjectRequest& request,
                             v1::GetObjectResponse* response);

/// A page of the snapshot's objects. `map` only marks the page tokens. Cost: a pass over the
/// objects until the page is full.
absl::Status AnswerListObjects(MapKey map,
                               const MapSnapshot& snapshot,
                               const v1::ListObjectsRequest& request,
                               v1::ListObjectsResponse* response);

/// A page of the map's events up to `revision`, read from `store`. Cost: about 1 us an event passed
/// over; after 100 000 of them a page ends even if it is not full.
absl::Status AnswerListEvents(Store& store,
                              MapKey map,
                              Revision revision,
                              const v1::ListEventsRequest& request,
                              v1::ListEventsResponse* response);

}  // namespace steadymap
