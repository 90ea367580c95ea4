#pragma once

#include <string>
#include <vector>

#include "client/bench/evaluation/truth/event_truth.h"
#include "core/map/object_event.h"

namespace steadymap {

/// Returns a line for each fault in the events of a map: a change in view that no event describes,
/// or more events than its objects; a move that is not told as one; a claim that describes no
/// change. Events describe changes as in `event_score.h`. An event that describes two changes, of
/// neighbours or of later sequences, counts for both, so that there may be a line although the
/// score is perfect. `truth` must include the capture times.
std::vector<std::string> ListEventFaults(const EventTruth& truth,
                                         const std::vector<ObjectEvent>& events);

}  // namespace steadymap
