#pragma once

#include "client/bench/evaluation/score/map_score.h"
#include "client/bench/evaluation/truth/route_survey.h"

namespace steadymap {

/// Builds the ground truth of a route. Moves the observed space out of the survey. Surface within a
/// voxel of true surface is neither `vanished` nor `swept`, and surface within a voxel of seen
/// surface is not `remembered`, since map surface there could match either.
Reference MakeReference(RouteSurvey* survey, bool with_ground);

}  // namespace steadymap
