#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "client/bench/evaluation/score/map_score.h"
#include "client/bench/evaluation/truth/event_truth.h"
#include "core/map/object_event.h"

/// How well a map's events tell what changed.
///
/// A move is a removal from the old place and a creation at the new one, and a map may report it as
/// one event or as two; so created and removed are scored for moves, too, and moves once more.
///
/// An event describes a change if all of this holds:
/// - class: the object's class is that of the things that changed;
/// - place: its centre, seen from above, lies within 0.4 m plus half the longer side of the centre
///   of one of the things, or of all of them together, and in height within 0.4 m of them;
/// - time: it came in the sequence that shows the change, or later.
/// What the first sequence creates, and what a later one sees for the first time, is neither right
/// nor wrong.
namespace steadymap {

/// Claims against the truth.
struct DetectionScore {
  Share right;  ///< Of what was claimed, what is true.
  Share found;  ///< Of what is true and in view, what was claimed.

  double precision() const { return right.value(); }

  double recall() const { return found.value(); }

  /// Harmonic mean of both; NaN where either is missing, 0 where both are 0.
  double f1() const;

  DetectionScore& operator+=(const DetectionScore& other);
};

/// Scores a kind of event each.
struct DetectionScores {
  DetectionScore created;
  DetectionScore removed;
  DetectionScore moved;

  /// Created and removed together, which holds moves twice over.
  DetectionScore all() const;

  DetectionScores& operator+=(const DetectionScores& other);
};

/// All that is said about the events of one map.
struct EventScore {
  /// Any number of events may describe one change. A move is found if its ends in view are.
  DetectionScores lenient;
  /// An event describes one change, and a change needs one event, a group one for each thing at
  /// most. A move is found if one event of that type tells both ends.
  DetectionScores one_to_one;
  /// For each end found, frames with its place in view until the event, that one included; rising.
  std::vector<std::size_t> latency_frames;
  std::uint64_t false_removals = 0;  ///< Removals (and moves away) that describe no change.
  std::uint64_t frame_count = 0;

  /// The middle of `latency_frames`; NaN for none.
  double median_latency_frames() const;

  /// The last of them; NaN for none.
  double max_latency_frames() const;

  /// NaN without frames.
  double false_removals_per_1000_frames() const;

  EventScore& operator+=(const EventScore& other);
};

/// Compares `events` with the truth, whose capture times must be known.
EventScore ScoreEvents(const EventTruth& truth, const std::vector<ObjectEvent>& events);

}  // namespace steadymap
