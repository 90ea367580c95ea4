#pragma once

#include <string>
#include <vector>

#include "client/bench/evaluation/truth/event_truth.h"
#include "core/map/object_event.h"

namespace steadymap {

/// Returns a line for each fault in the events of a map, by the rules of `event_score.h`: a change
/// in view that no event describes, or more events than its objects; a move that is not told as
/// one; a claim that describes no change. `truth` must include the capture times.
std::vector<std::string> ListEventFaults(const EventTruth& truth,
                                         const std::vector<ObjectEvent>& events);

}  // namespace steadymap
