#pragma once

#include "client/bench/evaluation/score/map_score.h"
#include "client/bench/evaluation/truth/route_survey.h"

namespace steadymap {

/// Sorts a route's surface into what the score asks for. The survey's observed space is moved out.
/// What lies within a voxel of true surface is neither `vanished` nor `swept`, and what lies within
/// a voxel of seen surface is not `remembered`: a map's surface there may stand for either.
Reference MakeReference(RouteSurvey* survey, bool with_ground);

}  // namespace steadymap
