#include "core/map/stationarity.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace steadymap {
namespace {

// Evidence alpha + beta of an object after its first observation. With E[v] = 2/3 it gives Beta(2,
// 1), as in Qian et al., RSS 2022.
constexpr double kInitialEvidence = 3.0;

// Limits of magnitudes, far beyond those of any map. Within them, no product of four values
// overflows or underflows.
constexpr double kSmallest = 1e-50;
constexpr double kLargest = 1e50;

double Positive(double value) { return std::clamp(value, kSmallest, kLargest); }

double Square(double value) { return value * value; }

/// The belief and the measurement, all within the range of `Positive`.
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

/// Returns the log of c1 / c2 (Qian et al., RSS 2022, supplement, equations 17 and 18) after
/// cancellation of the gamma functions.
double InlierLogOdds(const Step& step) {
  const double variance_m2 = step.noise_variance_m2 + step.variance_m2;
  const double log_normal = -0.5 * (std::log(2.0 * std::numbers::pi * variance_m2) +
                                    Square(step.change_m - step.mean_m) / variance_m2);
  const double log_uniform = -std::log(2.0 * step.max_change_m);
  return std::log(step.alpha) + log_normal - std::log(step.beta) - log_uniform;
}

double Logistic(double log_odds) { return 1.0 / (1.0 + std::exp(-log_odds)); }

/// Adds the evidence of the class if it agrees with the measurement (Qian et al., RSS 2022, table
/// 2).
void AddClassEvidence(StationarityPrior class_prior, double class_weight, Step* step) {
  const bool inlier = InlierLogOdds(*step) > 0.0;
  const double weight = std::clamp(class_weight, 0.0, kLargest);
  if (class_prior == StationarityPrior::kStationary && inlier) step->alpha += weight;
  if (class_prior == StationarityPrior::kMobile && !inlier) step->beta += weight;
}

/// Returns the Gaussian and the Beta with the moments of the exact posterior, a mixture of two
/// components.
///
/// The formulas of Qian et al., RSS 2022, supplement, equations 17 to 23, with the differences of
/// moments expanded (`core/README.md`). All remaining terms are positive, so there is no
/// cancellation even for narrow beliefs.
Belief MatchMoments(const Step& step, double inlier, double outlier) {
  const double gain = step.variance_m2 / (step.variance_m2 + step.noise_variance_m2);
  const double fused_variance_m2 = gain * step.noise_variance_m2;
  const double shift_m = gain * (step.change_m - step.mean_m);
  const double variance_m2 =
      inlier * fused_variance_m2 + outlier * step.variance_m2 + inlier * outlier * Square(shift_m);

  // `within` is the variance within the two Betas, `between` the variance of their means, both
  // times (n + 1)^2 (n + 2). `share` is the evidence of the single Beta relative to n + 1.
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

StationarityPrior PriorOf(const MapConfig& config, ClassId class_id) {
  const SemanticClass* row = config.FindClass(class_id);
  return row == nullptr || row->motion == ClassMotion::kStatic ? StationarityPrior::kStationary
                                                               : StationarityPrior::kMobile;
}

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
