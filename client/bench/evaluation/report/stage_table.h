#pragma once

#include <string>

#include "client/bench/evaluation/report/evaluation.h"

namespace steadymap {

/// Returns the mean milliseconds per frame of each stage as a text table, one line per method,
/// ending with a line feed. The cost of the commits, one every 15 frames, is distributed over all
/// frames.
std::string StageTable(const Evaluation& evaluation);

}  // namespace steadymap
