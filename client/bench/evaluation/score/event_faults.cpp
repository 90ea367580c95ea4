#include "client/bench/evaluation/score/event_faults.h"

#include <algorithm>
#include <cstddef>

#include <absl/strings/str_format.h>

#include "client/bench/evaluation/score/event_match.h"
#include "client/bench/evaluation/truth/place_text.h"
#include "core/types/absl_text.h"

namespace steadymap {
namespace {

const char* EndName(bool is_arrival) { return is_arrival ? "arrival" : "departure"; }

std::string FaultOf(const char* fault, const EventTruth& truth, const EndKey& key) {
  const TrueChange& change = truth.changes[key.change];
  return absl::StrFormat("%s: %s of %s, class %d, at %s, sequence %d",
                         fault,
                         EndName(key.is_arrival),
                         change.name,
                         change.class_id.value(),
                         PlaceText(EndOf(truth, key).boxes_world.front().center()),
                         change.sequence);
}

}  // namespace

std::vector<std::string> ListEventFaults(const EventTruth& truth,
                                         const std::vector<ObjectEvent>& events) {
  const std::vector<Claim> claims = ListClaims(truth, events);
  std::vector<bool> is_right(claims.size(), false);
  std::vector<std::string> faults;
  for (const EndKey& key : ListEnds(truth)) {
    std::size_t count = 0;
    bool is_told_as_move = false;
    for (std::size_t i = 0; i < claims.size(); ++i) {
      if (!Describes(claims[i], truth, key)) continue;
      is_right[i] = true;
      ++count;
      is_told_as_move = is_told_as_move || events[claims[i].event].type == EventType::kMoved;
    }
    const ChangeEnd& end = EndOf(truth, key);
    if (count == 0 && end.is_in_view) faults.push_back(FaultOf("missing", truth, key));
    if (count > end.boxes_world.size()) faults.push_back(FaultOf("told twice", truth, key));
    if (count > 0 && truth.changes[key.change].is_move() && !is_told_as_move) {
      faults.push_back(FaultOf("not told as moved", truth, key));
    }
  }
  for (std::size_t i = 0; i < claims.size(); ++i) {
    if (is_right[i]) continue;
    faults.push_back(absl::StrFormat("false: %s told by %s, class %d, at %s, frame %d",
                                     EndName(claims[i].is_arrival),
                                     Absl(NameOf(events[claims[i].event].type)),
                                     claims[i].class_id.value(),
                                     PlaceText(claims[i].center_world),
                                     claims[i].frame));
  }
  return faults;
}

}  // namespace steadymap
