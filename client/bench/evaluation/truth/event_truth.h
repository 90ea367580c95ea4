#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "client/bench/evaluation/truth/route_survey.h"
#include "core/types/identifiers.h"
#include "core/types/timestamp.h"

/// What truly changed on a simulated route, for the events of a map to be compared with.
namespace steadymap {

/// One end of a change: the place that was left, or the one that was taken.
struct ChangeEnd {
  std::vector<Eigen::AlignedBox3d> boxes_world;  ///< One a thing; empty: the change lacks this end.
  bool is_in_view = false;  ///< Whether the robot could notice: see `ListTrueEvents`.
  std::vector<std::size_t> frames_in_view;  ///< Of the change's sequence, rising.
};

/// A thing that is not where it was a sequence before, or several of one group that changed alike:
/// things that touch and look alike may be one object of a map.
struct TrueChange {
  std::string name;  ///< Of the first thing.
  ClassId class_id;
  std::size_t sequence = 0;  ///< The first in which it is true.
  ChangeEnd departure;       ///< Empty for what was created.
  ChangeEnd arrival;         ///< Empty for what was removed.

  bool is_move() const { return !departure.boxes_world.empty() && !arrival.boxes_world.empty(); }
};

/// Something that a sequence is the first to see although it may always have been there.
struct FirstSight {
  ClassId class_id;
  std::size_t sequence = 0;
  Eigen::AlignedBox3d box_world;
};

/// The truth about a route's events.
struct EventTruth {
  std::vector<TrueChange> changes;        ///< By rising sequence.
  std::vector<FirstSight> first_sights;   ///< To be created by a map, though nothing changed.
  std::vector<Timestamp> capture_times;   ///< Of all frames.
  std::vector<std::size_t> first_frames;  ///< Of each sequence, then the number of frames.
};

/// Compares each sequence with the one before. The first has no changes: all is new to the map.
///
/// A departure is in view if the sequence looked through at least 0.1 m2 of surface that an earlier
/// one had seen at the place; an arrival, if it saw at least 0.1 m2 of the new surface. Things that
/// move while the robot looks are no part of it. The capture times are left empty.
EventTruth ListTrueEvents(const Route& route, const RouteSurvey& survey);

}  // namespace steadymap
