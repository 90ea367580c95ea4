#pragma once

#include <string>

#include "client/bench/evaluation/report/evaluation.h"

namespace steadymap {

/// Mean milliseconds a frame by stage, a line a method: a table for people, with a line feed at its
/// end. The commits of every 15th frame are shared out among all.
std::string StageTable(const Evaluation& evaluation);

}  // namespace steadymap
