#pragma once

#include <absl/status/status.h>

#include "core/map/map_snapshot.h"
#include "core/types/cancellation.h"
#include "core/types/identifiers.h"
#include "server/query/query_selection.h"
#include "server/store/model/store.h"

#include "steadymap/v1/query_service.pb.h"

/// What the queries about objects and their history answer. Requests are checked here; field paths
/// are those of the request. Lists end with `Cancelled`, as `cancellation` says. Any thread.
namespace steadymap {

/// One object of the snapshot. Errors: `NotFound` with the name's field.
absl::Status AnswerGetObject(const MapSnapshot& snapshot,
                             const ObjectName& name,
                             v1::GetObjectResponse* response);

/// A page of the snapshot's objects. `map` only marks the page tokens. Cost: a pass over the
/// objects until the page is full.
absl::Status AnswerListObjects(MapKey map,
                               const MapSnapshot& snapshot,
                               const v1::ListObjectsRequest& request,
                               const Cancellation& cancellation,
                               v1::ListObjectsResponse* response);

}  // namespace steadymap
