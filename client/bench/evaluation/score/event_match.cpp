#include "client/bench/evaluation/score/event_match.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace steadymap {
namespace {

// If only part of an object was observed, its cuboid's centre is off by up to half its size; errors
// of poses and surfaces are small in comparison.
constexpr double kPlaceToleranceM = 0.4;

bool IsAt(const Eigen::Vector3d& center_world, const Eigen::AlignedBox3d& box_world) {
  const Eigen::Vector3d size_m = box_world.sizes();
  const Eigen::Vector3d offset_m = center_world - box_world.center();
  return offset_m.head<2>().norm() <= kPlaceToleranceM + 0.5 * size_m.head<2>().maxCoeff() &&
         std::abs(offset_m.z()) <= kPlaceToleranceM + 0.5 * size_m.z();
}

bool IsAtAny(const Eigen::Vector3d& center_world,
             const std::vector<Eigen::AlignedBox3d>& boxes_world) {
  Eigen::AlignedBox3d all_world;
  for (const Eigen::AlignedBox3d& box_world : boxes_world) {
    if (IsAt(center_world, box_world)) return true;
    all_world.extend(box_world);
  }
  return !boxes_world.empty() && IsAt(center_world, all_world);
}

bool IsFirstSight(const Claim& claim, const EventTruth& truth) {
  return std::any_of(
      truth.first_sights.begin(), truth.first_sights.end(), [&claim](const FirstSight& sight) {
        return sight.sequence == claim.sequence && sight.class_id == claim.class_id &&
               IsAt(claim.center_world, sight.box_world);
      });
}

bool DescribesAny(const Claim& claim, const EventTruth& truth) {
  const std::vector<EndKey> ends = ListEnds(truth);
  return std::any_of(
      ends.begin(), ends.end(), [&](const EndKey& end) { return Describes(claim, truth, end); });
}

// Returns the last frame captured at or before the event.
std::size_t FrameOf(const EventTruth& truth, Timestamp time) {
  const auto after = std::upper_bound(truth.capture_times.begin(), truth.capture_times.end(), time);
  return after == truth.capture_times.begin()
             ? 0
             : static_cast<std::size_t>(after - truth.capture_times.begin()) - 1;
}

std::size_t SequenceOf(const EventTruth& truth, std::size_t frame) {
  const auto after =
      std::upper_bound(truth.first_frames.begin(), truth.first_frames.end() - 1, frame);
  return static_cast<std::size_t>(after - truth.first_frames.begin()) - 1;
}

constexpr std::size_t kFree = static_cast<std::size_t>(-1);

// One step of the matching (an augmenting path): assigns a candidate to `slot`, reassigning others
// if needed. Slots with a candidate never lose it.
bool FindCandidate(std::size_t slot,
                   const Candidates& candidates,
                   std::vector<bool>* visited,
                   std::vector<std::size_t>* slot_of_candidate) {
  for (const std::size_t candidate : candidates[slot]) {
    if ((*visited)[candidate]) continue;
    (*visited)[candidate] = true;
    const std::size_t other = (*slot_of_candidate)[candidate];
    if (other == kFree || FindCandidate(other, candidates, visited, slot_of_candidate)) {
      (*slot_of_candidate)[candidate] = slot;
      return true;
    }
  }
  return false;
}

}  // namespace

std::vector<Claim> ListClaims(const EventTruth& truth, const std::vector<ObjectEvent>& events) {
  std::vector<Claim> claims;
  for (std::size_t i = 0; i < events.size(); ++i) {
    const ObjectEvent& event = events[i];
    Claim claim;
    claim.event = i;
    claim.class_id = event.class_id;
    claim.frame = FrameOf(truth, event.time);
    claim.sequence = SequenceOf(truth, claim.frame);
    const bool is_move = event.type == EventType::kMoved;
    if (is_move || event.type == EventType::kRemoved) {
      claim.center_world =
          is_move ? event.old_center_world.value_or(event.center_world) : event.center_world;
      claims.push_back(claim);
    }
    claim.is_arrival = true;
    claim.center_world = event.center_world;
    const bool is_created = event.type == EventType::kCreated || event.type == EventType::kReturned;
    const bool is_neutral = is_created && !DescribesAny(claim, truth) &&
                            (claim.sequence == 0 || IsFirstSight(claim, truth));
    if (is_move || (is_created && !is_neutral)) claims.push_back(claim);
  }
  return claims;
}

std::vector<EndKey> ListEnds(const EventTruth& truth) {
  std::vector<EndKey> ends;
  for (std::size_t i = 0; i < truth.changes.size(); ++i) {
    for (const bool is_arrival : {false, true}) {
      if (!EndOf(truth, {i, is_arrival}).boxes_world.empty()) ends.push_back({i, is_arrival});
    }
  }
  return ends;
}

const ChangeEnd& EndOf(const EventTruth& truth, const EndKey& key) {
  const TrueChange& change = truth.changes[key.change];
  return key.is_arrival ? change.arrival : change.departure;
}

bool Describes(const Claim& claim, const EventTruth& truth, const EndKey& key) {
  const TrueChange& change = truth.changes[key.change];
  return claim.is_arrival == key.is_arrival && claim.class_id == change.class_id &&
         claim.sequence >= change.sequence &&
         IsAtAny(claim.center_world, EndOf(truth, key).boxes_world);
}

std::vector<std::size_t> CountMatches(const Candidates& candidates,
                                      const std::vector<std::size_t>& capacities,
                                      std::size_t candidate_count) {
  // One slot per taker comes first, then the slots of capacities above one, which get only the
  // remaining candidates.
  std::vector<std::size_t> taker_of_slot(candidates.size());
  std::iota(taker_of_slot.begin(), taker_of_slot.end(), 0U);
  for (std::size_t taker = 0; taker < candidates.size(); ++taker) {
    taker_of_slot.insert(taker_of_slot.end(), capacities[taker] - 1, taker);
  }
  Candidates slots;
  slots.reserve(taker_of_slot.size());
  for (const std::size_t taker : taker_of_slot) slots.push_back(candidates[taker]);

  std::vector<std::size_t> slot_of_candidate(candidate_count, kFree);
  std::vector<std::size_t> counts(candidates.size(), 0);
  for (std::size_t slot = 0; slot < slots.size(); ++slot) {
    std::vector<bool> visited(candidate_count, false);
    if (FindCandidate(slot, slots, &visited, &slot_of_candidate)) ++counts[taker_of_slot[slot]];
  }
  return counts;
}

}  // namespace steadymap
