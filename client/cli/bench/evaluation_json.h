#pragma once

#include <vector>

#include "client/bench/evaluation/report/evaluation.h"
#include "client/cli/text/json_text.h"

namespace steadymap {

/// Returns the tables as one JSON document: an array of objects with all values of `ScoreTable`,
/// shares in [0, 1], the counts behind them, and NaN, which is written as null, for undefined
/// values.
Json EvaluationJson(const std::vector<Evaluation>& evaluations);

}  // namespace steadymap
