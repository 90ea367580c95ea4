#include "client/bench/evaluation/score/event_score.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "client/bench/evaluation/score/event_match.h"

namespace steadymap {
namespace {

/// Compares the claims of one map with the ends of the changes.
class EventScorer {
 public:
  EventScorer(const EventTruth& truth, const std::vector<ObjectEvent>& events)
      : truth_(truth),
        events_(events),
        claims_(ListClaims(truth, events)),
        ends_(ListEnds(truth)) {}

  EventScore Score() const {
    EventScore score;
    score.frame_count = truth_.capture_times.size();
    ScoreLenient(&score);
    ScoreOneToOne(&score.one_to_one);
    ScoreMoves(&score);
    std::sort(score.latency_frames.begin(), score.latency_frames.end());
    return score;
  }

 private:
  static DetectionScore& ScoreOf(bool is_arrival, DetectionScores* scores) {
    return is_arrival ? scores->created : scores->removed;
  }

  // Returns the first claim about an end, or null.
  const Claim* FirstClaim(const EndKey& end) const {
    const auto found = std::find_if(claims_.begin(), claims_.end(), [&](const Claim& claim) {
      return Describes(claim, truth_, end);
    });
    return found == claims_.end() ? nullptr : &*found;
  }

  void ScoreLenient(EventScore* score) const {
    for (const Claim& claim : claims_) {
      const bool is_right = std::any_of(ends_.begin(), ends_.end(), [&](const EndKey& end) {
        return Describes(claim, truth_, end);
      });
      ScoreOf(claim.is_arrival, &score->lenient).right += {is_right ? 1U : 0U, 1};
      if (!is_right && !claim.is_arrival) ++score->false_removals;
    }
    for (const EndKey& end : ends_) {
      if (!EndOf(truth_, end).is_in_view) continue;
      const Claim* const claim = FirstClaim(end);
      ScoreOf(end.is_arrival, &score->lenient).found += {claim != nullptr ? 1U : 0U, 1};
      if (claim == nullptr) continue;
      const std::vector<std::size_t>& frames = EndOf(truth_, end).frames_in_view;
      const auto after = std::upper_bound(frames.begin(), frames.end(), claim->frame);
      score->latency_frames.push_back(static_cast<std::size_t>(after - frames.begin()));
    }
  }

  void ScoreOneToOne(DetectionScores* scores) const {
    Candidates candidates(ends_.size());
    std::vector<std::size_t> capacities;
    for (std::size_t end = 0; end < ends_.size(); ++end) {
      capacities.push_back(EndOf(truth_, ends_[end]).boxes_world.size());
      for (std::size_t claim = 0; claim < claims_.size(); ++claim) {
        if (Describes(claims_[claim], truth_, ends_[end])) candidates[end].push_back(claim);
      }
    }
    const std::vector<std::size_t> matches = CountMatches(candidates, capacities, claims_.size());
    for (const Claim& claim : claims_) ++ScoreOf(claim.is_arrival, scores).right.whole;
    for (std::size_t end = 0; end < ends_.size(); ++end) {
      DetectionScore& score = ScoreOf(ends_[end].is_arrival, scores);
      score.right.part += matches[end];
      if (EndOf(truth_, ends_[end]).is_in_view) score.found += {matches[end] > 0 ? 1U : 0U, 1};
    }
  }

  // True if the two claims of a move event describe both ends of one move.
  bool TellsMove(std::size_t event, std::size_t change) const {
    bool tells_departure = false;
    bool tells_arrival = false;
    for (const Claim& claim : claims_) {
      if (claim.event != event) continue;
      tells_departure = tells_departure || Describes(claim, truth_, {change, false});
      tells_arrival = tells_arrival || Describes(claim, truth_, {change, true});
    }
    return tells_departure && tells_arrival;
  }

  bool EndsAreFound(std::size_t change) const {
    return std::all_of(ends_.begin(), ends_.end(), [&](const EndKey& end) {
      return end.change != change || !EndOf(truth_, end).is_in_view || FirstClaim(end) != nullptr;
    });
  }

  void ScoreMoves(EventScore* score) const {
    std::vector<std::size_t> told;
    for (std::size_t i = 0; i < events_.size(); ++i) {
      if (events_[i].type == EventType::kMoved) told.push_back(i);
    }
    std::vector<std::size_t> moves;
    std::vector<std::size_t> capacities;
    Candidates candidates;
    std::set<std::size_t> right;
    for (std::size_t move = 0; move < truth_.changes.size(); ++move) {
      if (!truth_.changes[move].is_move()) continue;
      moves.push_back(move);
      capacities.push_back(truth_.changes[move].arrival.boxes_world.size());
      std::vector<std::size_t>& candidate = candidates.emplace_back();
      for (std::size_t i = 0; i < told.size(); ++i) {
        if (TellsMove(told[i], move)) candidate.push_back(i);
      }
      right.insert(candidate.begin(), candidate.end());
    }
    score->lenient.moved.right = {right.size(), told.size()};
    score->one_to_one.moved.right.whole = told.size();
    const std::vector<std::size_t> matches = CountMatches(candidates, capacities, told.size());
    for (std::size_t i = 0; i < moves.size(); ++i) {
      score->one_to_one.moved.right.part += matches[i];
      const TrueChange& move = truth_.changes[moves[i]];
      if (!move.departure.is_in_view && !move.arrival.is_in_view) continue;
      score->one_to_one.moved.found += {matches[i] > 0 ? 1U : 0U, 1};
      const bool is_found = !candidates[i].empty() || EndsAreFound(moves[i]);
      score->lenient.moved.found += {is_found ? 1U : 0U, 1};
    }
  }

  const EventTruth& truth_;
  const std::vector<ObjectEvent>& events_;
  std::vector<Claim> claims_;
  std::vector<EndKey> ends_;
};

}  // namespace

double DetectionScore::f1() const {
  const double sum = precision() + recall();
  return sum > 0.0 ? 2.0 * precision() * recall() / sum : sum;
}

DetectionScore& DetectionScore::operator+=(const DetectionScore& other) {
  right += other.right;
  found += other.found;
  return *this;
}

DetectionScore DetectionScores::all() const {
  DetectionScore sum = created;
  return sum += removed;
}

DetectionScores& DetectionScores::operator+=(const DetectionScores& other) {
  created += other.created;
  removed += other.removed;
  moved += other.moved;
  return *this;
}

double EventScore::median_latency_frames() const {
  if (latency_frames.empty()) return std::numeric_limits<double>::quiet_NaN();
  return static_cast<double>(latency_frames[latency_frames.size() / 2]);
}

double EventScore::max_latency_frames() const {
  if (latency_frames.empty()) return std::numeric_limits<double>::quiet_NaN();
  return static_cast<double>(latency_frames.back());
}

double EventScore::false_removals_per_1000_frames() const {
  return 1000.0 * static_cast<double>(false_removals) / static_cast<double>(frame_count);
}

EventScore& EventScore::operator+=(const EventScore& other) {
  lenient += other.lenient;
  one_to_one += other.one_to_one;
  latency_frames.insert(
      latency_frames.end(), other.latency_frames.begin(), other.latency_frames.end());
  std::sort(latency_frames.begin(), latency_frames.end());
  false_removals += other.false_removals;
  frame_count += other.frame_count;
  return *this;
}

EventScore ScoreEvents(const EventTruth& truth, const std::vector<ObjectEvent>& events) {
  return EventScorer(truth, events).Score();
}

}  // namespace steadymap
