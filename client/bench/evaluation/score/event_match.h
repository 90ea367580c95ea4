#pragma once

#include <cstddef>
#include <vector>

#include "client/bench/evaluation/truth/event_truth.h"
#include "core/map/object_event.h"

/// Private to the event score: matching of events and changes.
namespace steadymap {

/// A claim of an event about one place: an object left it, or an object arrived.
struct Claim {
  std::size_t event = 0;  ///< Index.
  bool is_arrival = false;
  ClassId class_id;
  std::size_t frame = 0;     ///< Frame of the decision.
  std::size_t sequence = 0;  ///< Sequence of that frame.
  Eigen::Vector3d center_world = Eigen::Vector3d::Zero();
};

/// One end (departure or arrival) of a true change.
struct EndKey {
  std::size_t change = 0;  ///< Index.
  bool is_arrival = false;
};

/// Returns the claims of all events, in their order; the departure of a move precedes its arrival.
/// Omits creations in the first sequence and first sights, see `event_score.h`.
std::vector<Claim> ListClaims(const EventTruth& truth, const std::vector<ObjectEvent>& events);

/// Returns the ends of all changes.
std::vector<EndKey> ListEnds(const EventTruth& truth);

const ChangeEnd& EndOf(const EventTruth& truth, const EndKey& key);

/// True if `claim` can describe that end: class, place and time match as in `event_score.h`.
bool Describes(const Claim& claim, const EventTruth& truth, const EndKey& key);

/// For each taker, the claims (or events) that can be assigned to it.
using Candidates = std::vector<std::vector<std::size_t>>;

/// Assigns each candidate to at most one taker: first so that as many takers as possible have one,
/// then as many candidates as possible up to the capacities. Returns the number assigned to each
/// taker.
std::vector<std::size_t> CountMatches(const Candidates& candidates,
                                      const std::vector<std::size_t>& capacities,
                                      std::size_t candidate_count);

}  // namespace steadymap
