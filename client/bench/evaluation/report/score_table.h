#pragma once

#include <string>

#include "client/bench/evaluation/report/evaluation.h"

namespace steadymap {

/// The scores as a table for people: a row a method, then what others reported for the route.
/// Percentages have one digit, false positive rates two; a dash stands for what there is nothing to
/// say about.
std::string ScoreTable(const Evaluation& evaluation);

}  // namespace steadymap
