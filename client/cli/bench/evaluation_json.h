#pragma once

#include <string>
#include <vector>

#include "client/bench/evaluation/report/evaluation.h"

namespace steadymap {

/// Returns the tables as one JSON document: an array of objects with all values of `ScoreTable`,
/// shares in [0, 1], the counts behind them, and null for undefined values.
std::string EvaluationJson(const std::vector<Evaluation>& evaluations);

}  // namespace steadymap
