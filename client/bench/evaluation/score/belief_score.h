#pragma once

#include <span>

namespace steadymap {

/// What a map believed of one object, and what is so.
struct BeliefSample {
  double stationarity = 0.0;   ///< E[v], in [0, 1].
  bool is_still_true = false;  ///< Whether the thing stands where the map has it.
};

/// The Brier score: the mean squared distance of belief and truth. 0 is perfect, 0.25 what always
/// believing one half gets; NaN for no samples.
double BrierScore(std::span<const BeliefSample> samples);

}  // namespace steadymap
