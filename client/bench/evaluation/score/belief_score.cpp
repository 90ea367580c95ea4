#include "client/bench/evaluation/score/belief_score.h"

namespace steadymap {

double BrierScore(std::span<const BeliefSample> samples) {
  double sum = 0.0;
  for (const BeliefSample& sample : samples) {
    const double error = sample.stationarity - (sample.is_still_true ? 1.0 : 0.0);
    sum += error * error;
  }
  return sum / static_cast<double>(samples.size());
}

}  // namespace steadymap
