#pragma once

#include <string>
#include <vector>

#include "client/bench/evaluation/report/evaluation.h"

namespace steadymap {

/// Tables as one JSON document: an array of objects with all that `ScoreTable` shows, shares in
/// [0, 1], the counts behind them, and null for what there is nothing to say about.
std::string EvaluationJson(const std::vector<Evaluation>& evaluations);

}  // namespace steadymap
