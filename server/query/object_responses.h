#pragma once

#include <absl/status/status.h>

#include "core/map/map_snapshot.h"
#include "core/types/cancellation.h"
#include "core/types/identifiers.h"
#include "server/query/query_selection.h"
#include "server/store/model/store.h"

#include "steadymap/v1/query_service.pb.h"

/// Responses to queries about objects. The functions check the request; field paths in errors are
/// relative to it. Thread-safe.
namespace steadymap {

/// Fills the response with one object of the snapshot. Errors: `NotFound` with the field of the
/// name.
absl::Status AnswerGetObject(const MapSnapshot& snapshot,
                             const ObjectName& name,
                             v1::GetObjectResponse* response);

/// Fills a page with the snapshot's objects. `map` is used only for the page tokens. Cost: a pass
/// over the objects until the page is full. Errors: those of an invalid request; `Cancelled`.
absl::Status AnswerListObjects(MapKey map,
                               const MapSnapshot& snapshot,
                               const v1::ListObjectsRequest& request,
                               const Cancellation& cancellation,
                               v1::ListObjectsResponse* response);

}  // namespace steadymap
