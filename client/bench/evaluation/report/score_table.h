#pragma once

#include <string>

#include "client/bench/evaluation/report/evaluation.h"

namespace steadymap {

/// Returns the scores as a text table: one row per method, then the scores reported by other
/// authors for the route. Percentages have one digit, false positive rates two; a dash marks an
/// undefined value. The last line holds the errors of the poses (`pose_score.h`), if known.
std::string ScoreTable(const Evaluation& evaluation);

/// Returns the faults in the events of each method, a line each; none for methods that observe no
/// changes.
std::string EventFaultText(const Evaluation& evaluation);

}  // namespace steadymap
