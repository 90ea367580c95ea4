#pragma once

#include <cstddef>
#include <vector>

#include "client/bench/evaluation/truth/event_truth.h"
#include "core/map/object_event.h"

/// Private to the score of events: which event may describe which change.
namespace steadymap {

/// What an event says of one place: that something left it, or that something took it.
struct Claim {
  std::size_t event = 0;  ///< Index.
  bool is_arrival = false;
  ClassId class_id;
  std::size_t frame = 0;     ///< That decided.
  std::size_t sequence = 0;  ///< Of that frame.
  Eigen::Vector3d center_world = Eigen::Vector3d::Zero();
};

/// One end of a change, as what claims are matched with.
struct EndKey {
  std::size_t change = 0;  ///< Index.
  bool is_arrival = false;
};

/// The claims of all events, in their order; the departure of a move before its arrival. Those of
/// creations in the first sequence and of first sights are left out, see `event_score.h`.
std::vector<Claim> ListClaims(const EventTruth& truth, const std::vector<ObjectEvent>& events);

/// The ends of all changes.
std::vector<EndKey> ListEnds(const EventTruth& truth);

const ChangeEnd& EndOf(const EventTruth& truth, const EndKey& key);

/// Whether `claim` may be about that end: class, place and time as in `event_score.h`.
bool Describes(const Claim& claim, const EventTruth& truth, const EndKey& key);

/// For each of some takers, the claims (or events) that it may take.
using Candidates = std::vector<std::vector<std::size_t>>;

/// Gives each candidate to one taker at most, so that first as many takers as possible get one,
/// then each up to its capacity as many as possible. Returns how many each one gets.
std::vector<std::size_t> CountMatches(const Candidates& candidates,
                                      const std::vector<std::size_t>& capacities,
                                      std::size_t candidate_count);

}  // namespace steadymap
