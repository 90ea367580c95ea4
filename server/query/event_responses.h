#pragma once

#include <absl/status/status.h>

#include "core/map/map_snapshot.h"
#include "core/types/cancellation.h"
#include "core/types/identifiers.h"
#include "server/store/model/store.h"

#include "steadymap/v1/query_service.pb.h"

namespace steadymap {

/// Fills a page with the map's events up to the revision of the snapshot, read from `store`. Cost:
/// about 1 us per event read; after 100 000 events the page ends even if it is not full. Errors:
/// those of an invalid request, with the field's path; `Cancelled`; those of the store.
absl::Status AnswerListEvents(Store& store,
                              MapKey map,
                              const MapSnapshot& snapshot,
                              const v1::ListEventsRequest& request,
                              const Cancellation& cancellation,
                              v1::ListEventsResponse* response);

}  // namespace steadymap
