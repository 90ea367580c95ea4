#pragma once

#include <span>

namespace steadymap {

/// A map's belief about one object, and the truth.
struct BeliefSample {
  double stationarity = 0.0;   ///< E[v], in [0, 1].
  bool is_still_true = false;  ///< The object is still in place.
};

/// Returns the Brier score: the mean squared difference of belief and truth. 0 is perfect; a
/// constant belief of one half scores 0.25; NaN without samples.
double BrierScore(std::span<const BeliefSample> samples);

}  // namespace steadymap
