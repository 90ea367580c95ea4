#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "client/bench/evaluation/truth/route_survey.h"
#include "core/types/identifiers.h"
#include "core/types/timestamp.h"

/// The true changes of a simulated route, as reference for the events of a map.
namespace steadymap {

/// One end of a change: the place that was left, or the new place.
struct ChangeEnd {
  /// One per object; empty: the change lacks this end.
  std::vector<Eigen::AlignedBox3d> boxes_world;
  bool is_in_view = false;                  ///< Observable: see `ListTrueEvents`.
  std::vector<std::size_t> frames_in_view;  ///< Of the change's sequence, ascending.
};

/// A change of one object between consecutive sequences, or the same kind of change of several
/// objects of one group: objects that touch and look alike may be one object of a map.
struct TrueChange {
  std::string name;  ///< Of the first object.
  ClassId class_id;
  std::size_t sequence = 0;  ///< The first sequence after the change.
  ChangeEnd departure;       ///< Empty for a created object.
  ChangeEnd arrival;         ///< Empty for a removed object.

  bool is_move() const { return !departure.boxes_world.empty() && !arrival.boxes_world.empty(); }
};

/// An object that a sequence observes first although it may have been present before.
struct FirstSight {
  ClassId class_id;
  std::size_t sequence = 0;
  Eigen::AlignedBox3d box_world;
};

/// The truth about a route's events.
struct EventTruth {
  std::vector<TrueChange> changes;        ///< In ascending order of sequence.
  std::vector<FirstSight> first_sights;   ///< Created by a map without a change.
  std::vector<Timestamp> capture_times;   ///< Of all frames.
  std::vector<std::size_t> first_frames;  ///< Of each sequence, then the number of frames.
};

/// Compares each sequence with the previous one. The first has no changes, since everything is new
/// to the map.
///
/// A departure is in view if the rays of the sequence pass through at least 0.1 m2 of surface that
/// an earlier one observed at the place; an arrival, if the sequence observes at least 0.1 m2 of
/// the new surface. Objects that move during a sequence are excluded. The capture times are left
/// empty.
EventTruth ListTrueEvents(const Route& route, const RouteSurvey& survey);

}  // namespace steadymap
