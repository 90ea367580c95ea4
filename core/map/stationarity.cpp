#include "core/map/stationarity.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace steadymap {
namespace {

// Evidence of an object seen once; with E[v] = 2/3 it is Beta(2, 1), as in the paper.
constexpr double kInitialEvidence = 3.0;

// Magnitudes outside are moved to these: no map comes near, and inside no product of four
// overflows or vanishes.
constexpr double kSmallest = 1e-50;
constexpr double kLargest = 1e50;

double Positive(double value) { return std::clamp(value, kSmallest, kLargest); }

double Square(double value) { return value * value; }

/// The state and the measurement, all within the range of `Positive`.
struct Step {
  double mean_m;
  double variance_m2;
  double alpha;
  double beta;
  double change_m;
  double noise_variance_m2;
  double max_change_m;
};

Step MakeStep(const Belief& prior, double change_m, const StationarityParameters& parameters) {
  const double max_change_m = Positive(parameters.max_change_m);
  return {std::clamp(prior.change_mean_m, -kLargest, kLargest),
          Square(Positive(prior.change_std_m)),
          Positive(prior.alpha),
          Positive(prior.beta),
          std::clamp(change_m, -max_change_m, max_change_m),
          Square(Positive(parameters.change_noise_m)),
          max_change_m};
}

/// Log of c1 / c2, supplement equations 17 and 18 after the gamma functions cancel.
double InlierLogOdds(const Step& step) {
  const double variance_m2 = step.noise_variance_m2 + step.variance_m2;
  const double log_normal = -0.5 * (std::log(2.0 * std::numbers::pi * variance_m2) +
                                    Square(step.change_m - step.mean_m) / variance_m2);
  const double log_uniform = -std::log(2.0 * step.max_change_m);
  return std::log(step.alpha) + log_normal - std::log(step.beta) - log_uniform;
}

double Logistic(double log_odds) { return 1.0 / (1.0 + std::exp(-log_odds)); }

/// Adds what the class says where it agrees with what was seen (paper, table 2).
void AddClassEvidence(StationarityPrior class_prior, double class_weight, Step* step) {
  const bool inlier = InlierLogOdds(*step) > 0.0;
  const double weight = std::clamp(class_weight, 0.0, kLargest);
  if (class_prior == StationarityPrior::kStays && inlier) step->alpha += weight;
  if (class_prior == StationarityPrior::kMoves && !inlier) step->beta += weight;
}

/// The Gaussian and the Beta with the moments of the exact posterior, a mixture of two.
///
/// The formulas of pocd.md section 4, with the differences of moments multiplied out: every term
/// that is left is positive, so nothing cancels however sharp the belief.
Belief MatchMoments(const Step& step, double inlier, double outlier) {
  const double gain = step.variance_m2 / (step.variance_m2 + step.noise_variance_m2);
  const double fused_variance_m2 = gain * step.noise_variance_m2;
  const double shift_m = gain * (step.change_m - step.mean_m);
  const double variance_m2 =
      inlier * fused_variance_m2 + outlier * step.variance_m2 + inlier * outlier * Square(shift_m);

  // `within` and `between` are the variance inside the two Betas and that of their means, both
  // times (n + 1)^2 (n + 2); their share says how much evidence one Beta can stand for.
  const double within =
      inlier * (step.alpha + 1.0) * step.beta + outlier * step.alpha * (step.beta + 1.0);
  const double between = inlier * outlier * (step.alpha + step.beta + 2.0);
  const double share = within / (within + between);

  return {step.mean_m + inlier * shift_m,
          std::sqrt(variance_m2),
          share * (step.alpha + inlier),
          share * (step.beta + outlier)};
}

void CapEvidence(double max_evidence, Belief* belief) {
  const double evidence = belief->alpha + belief->beta;
  if (evidence <= max_evidence) return;
  belief->alpha *= max_evidence / evidence;
  belief->beta *= max_evidence / evidence;
}

}  // namespace

Belief InitialBelief(double stationarity) {
  Belief belief;
  belief.alpha = kInitialEvidence * stationarity;
  belief.beta = kInitialEvidence * (1.0 - stationarity);
  return belief;
}

StationarityUpdate UpdateStationarity(const Belief& prior,
                                      double change_m,
                                      StationarityPrior class_prior,
                                      const StationarityParameters& parameters) {
  Step step = MakeStep(prior, change_m, parameters);
  const double prior_stationarity = step.alpha / (step.alpha + step.beta);
  AddClassEvidence(class_prior, parameters.class_weight, &step);
  const double log_odds = InlierLogOdds(step);
  const double inlier = Logistic(log_odds);

  Belief updated = MatchMoments(step, inlier, Logistic(-log_odds));
  const double stationarity = updated.stationarity();
  if (stationarity > parameters.max_stationarity && stationarity > prior_stationarity) {
    return {prior, inlier};
  }
  CapEvidence(parameters.max_evidence, &updated);
  return {updated, inlier};
}

}  // namespace steadymap
