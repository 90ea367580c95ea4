#pragma once

#include <string>
#include <vector>

#include "client/bench/evaluation/composite/composite_case.h"
#include "client/bench/evaluation/method/method_run.h"
#include "client/bench/evaluation/score/event_score.h"
#include "client/bench/evaluation/score/map_score.h"
#include "client/bench/evaluation/score/pose_score.h"
#include "client/bench/evaluation/truth/surface_points.h"

namespace steadymap {

/// What a map of two drives is compared with.
struct CompositeTruth {
  CompositeCase things;
  EventTruth events;
  std::vector<SurfacePoint> room;  ///< Surface of the recording alone.
  CameraPath recorded;             ///< Poses of the recording, which count as true.
  double spacing_m = 0.05;         ///< Between points of the room; surfaces so far apart agree.
  double cuboid_m = 0.04;          ///< Largest error of a face of a right cuboid.
};

/// The result of one case.
struct CompositeScore {
  DetectionScore events;  ///< Creations and removals, matched one to one; a move is one of each.
  Share moves;            ///< Moves and turns that one event of type moved tells.
  Share cuboids;          ///< Things with a right cuboid.
  Share ghosts;           ///< Surface that things have left, in the map.
  Share kept;             ///< Surface of the room, in the map.
  PoseScore poses;        ///< As registered; no points if the method registers no frames.
  std::vector<std::string> faults;

  CompositeScore& operator+=(const CompositeScore& other);
};

/// Returns the true changes between both drives. `class_id`: of all things.
EventTruth ListCompositeEvents(const CompositeCase& things, ClassId class_id);

/// Compares the map of two drives with the truth.
CompositeScore ScoreComposite(const CompositeTruth& truth, const MethodOutcome& outcome);

}  // namespace steadymap
