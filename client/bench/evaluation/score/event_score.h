#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "client/bench/evaluation/score/map_score.h"
#include "client/bench/evaluation/truth/event_truth.h"
#include "core/map/object_event.h"

/// Accuracy of a map's events.
///
/// A move is a removal at the old place and a creation at the new one, and a map may report it as
/// one event or two. Moves therefore count in the scores of created, removed and moved.
///
/// An event describes a change if all conditions hold:
/// - class: the object has the class of the changed objects;
/// - place: its centre lies horizontally within 0.4 m plus half the longer side of the centre of
/// one
///   changed object, or of all of them together, and vertically within 0.4 m of them;
/// - time: it is in the sequence that shows the change, or later.
///
/// Creations in the first sequence, and creations of objects first observed in a later one, are
/// neither right nor wrong.
namespace steadymap {

/// Claims compared with the truth.
struct DetectionScore {
  Share right;  ///< True claims among all claims.
  Share found;  ///< Claimed changes among all true changes in view.

  double precision() const { return right.value(); }

  double recall() const { return found.value(); }

  /// Harmonic mean of both; NaN if either is NaN, 0 if both are 0.
  double f1() const;

  DetectionScore& operator+=(const DetectionScore& other);
};

/// Scores per event type.
struct DetectionScores {
  DetectionScore created;
  DetectionScore removed;
  DetectionScore moved;

  /// Created and removed together; it counts moves twice.
  DetectionScore all() const;

  DetectionScores& operator+=(const DetectionScores& other);
};

/// All scores of the events of one map.
struct EventScore {
  /// Any number of events may describe one change. A move counts as found if all its ends in view
  /// are.
  DetectionScores lenient;
  /// One event describes one change, and one change needs one event; a group accepts one event per
  /// object. A move counts as found if one event of type moved describes both ends.
  DetectionScores one_to_one;
  /// For each end found: frames with its place in view up to and including the event; ascending.
  std::vector<std::size_t> latency_frames;
  std::uint64_t false_removals = 0;  ///< Removals and departures that match no change.
  std::uint64_t frame_count = 0;

  /// Median of `latency_frames`; NaN if empty.
  double median_latency_frames() const;

  /// Maximum of `latency_frames`; NaN if empty.
  double max_latency_frames() const;

  /// NaN without frames.
  double false_removals_per_1000_frames() const;

  EventScore& operator+=(const EventScore& other);
};

/// Compares `events` with the truth, which must include the capture times.
EventScore ScoreEvents(const EventTruth& truth, const std::vector<ObjectEvent>& events);

}  // namespace steadymap
