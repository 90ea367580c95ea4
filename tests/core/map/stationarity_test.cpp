// Oracle: the exact posterior, integrated numerically over both unknowns.

#include "core/map/stationarity.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/special_numbers.h"

namespace steadymap {
namespace {

using ::steadymap::testing::kInfinity;

StationarityParameters PublishedParameters() {
  StationarityParameters parameters;
  parameters.max_evidence = kInfinity;
  return parameters;
}

double NormalDensity(double value, double mean, double std) {
  const double ratio = (value - mean) / std;
  return std::exp(-0.5 * ratio * ratio) / (std * std::sqrt(2.0 * std::numbers::pi));
}

/// Moments of a density that may be unnormalised.
struct Moments {
  double mass = 0.0;
  double change_m = 0.0;
  double change_squared_m2 = 0.0;
  double stationarity = 0.0;
  double stationarity_squared = 0.0;
  double inlier_probability = 0.0;
};

/// A node of a quadrature over one unknown: its position, and the prior density at this position
/// times the quadrature weight.
struct Node {
  double place;
  double weight;
};

/// Returns nodes of the trapezoidal rule, which converges exponentially for an analytic density
/// that vanishes at both ends.
std::vector<Node> ChangeNodes(const Belief& prior, double change_m, double noise_m) {
  const double step_m = std::min(prior.change_std_m, noise_m) / 3.0;
  const double low_m = std::min(prior.change_mean_m, change_m) - 10.0 * prior.change_std_m;
  const double high_m = std::max(prior.change_mean_m, change_m) + 10.0 * prior.change_std_m;
  const int count = static_cast<int>(std::ceil((high_m - low_m) / step_m));
  std::vector<Node> nodes;
  nodes.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    const double place_m = low_m + i * step_m;
    nodes.push_back(
        {place_m, step_m * NormalDensity(place_m, prior.change_mean_m, prior.change_std_m)});
  }
  return nodes;
}

/// Returns nodes over x with v = 1 / (1 + exp(-x)), for which the Beta density vanishes at both
/// ends. The weights include the factor p(s | v)^k.
std::vector<Node> StationarityNodes(const Belief& prior, double stays_weight, double moves_weight) {
  constexpr double kStep = 0.1;
  constexpr int kStepsEachWay = 600;
  const double alpha = prior.alpha + stays_weight;
  const double beta = prior.beta + moves_weight;
  std::vector<Node> nodes;
  nodes.reserve(2 * kStepsEachWay + 1);
  for (int i = -kStepsEachWay; i <= kStepsEachWay; ++i) {
    const double x = kStep * i;
    const double log_v = -std::log1p(std::exp(-x));
    const double log_rest = -std::log1p(std::exp(x));
    nodes.push_back({std::exp(log_v), kStep * std::exp(alpha * log_v + beta * log_rest)});
  }
  return nodes;
}

Moments Integrate(const std::vector<Node>& changes,
                  const std::vector<Node>& stationarities,
                  double change_m,
                  const StationarityParameters& parameters) {
  const double uniform = 0.5 / parameters.max_change_m;
  Moments sum;
  for (const Node& l : changes) {
    const double normal = NormalDensity(change_m, l.place, parameters.change_noise_m);
    for (const Node& v : stationarities) {
      const double inlier = l.weight * v.weight * v.place * normal;
      const double density = inlier + l.weight * v.weight * (1.0 - v.place) * uniform;
      sum.mass += density;
      sum.inlier_probability += inlier;
      sum.change_m += density * l.place;
      sum.change_squared_m2 += density * l.place * l.place;
      sum.stationarity += density * v.place;
      sum.stationarity_squared += density * v.place * v.place;
    }
  }
  return {1.0,
          sum.change_m / sum.mass,
          sum.change_squared_m2 / sum.mass,
          sum.stationarity / sum.mass,
          sum.stationarity_squared / sum.mass,
          sum.inlier_probability / sum.mass};
}

/// Returns the moments of the exact posterior. The exponent k of the class likelihood is that of
/// table 2 of the paper.
Moments ExactMoments(const Belief& prior,
                     double change_m,
                     StationarityPrior class_prior,
                     const StationarityParameters& parameters) {
  const std::vector<Node> changes = ChangeNodes(prior, change_m, parameters.change_noise_m);
  const Moments plain = Integrate(changes, StationarityNodes(prior, 0, 0), change_m, parameters);
  const bool inlier = plain.inlier_probability > 0.5;
  const double k = parameters.class_weight;
  if (class_prior == StationarityPrior::kStationary && inlier) {
    return Integrate(changes, StationarityNodes(prior, k, 0), change_m, parameters);
  }
  if (class_prior == StationarityPrior::kMobile && !inlier) {
    return Integrate(changes, StationarityNodes(prior, 0, k), change_m, parameters);
  }
  return plain;
}

Moments MomentsOf(const StationarityUpdate& update) {
  const Belief& belief = update.belief;
  const double evidence = belief.alpha + belief.beta;
  return {1.0,
          belief.change_mean_m,
          belief.change_mean_m * belief.change_mean_m + belief.change_std_m * belief.change_std_m,
          belief.alpha / evidence,
          belief.alpha * (belief.alpha + 1.0) / (evidence * (evidence + 1.0)),
          update.inlier_probability};
}

void ExpectSameMoments(const Moments& exact, const Moments& found) {
  const double change_scale_m = std::sqrt(exact.change_squared_m2);
  EXPECT_NEAR(found.change_m, exact.change_m, 1e-6 * change_scale_m);
  EXPECT_NEAR(found.change_squared_m2, exact.change_squared_m2, 1e-6 * exact.change_squared_m2);
  EXPECT_NEAR(found.stationarity, exact.stationarity, 1e-6 * exact.stationarity);
  EXPECT_NEAR(
      found.stationarity_squared, exact.stationarity_squared, 1e-6 * exact.stationarity_squared);
  EXPECT_NEAR(found.inlier_probability, exact.inlier_probability, 1e-6 * exact.inlier_probability);
}

void ExpectProper(const StationarityUpdate& update) {
  EXPECT_TRUE(std::isfinite(update.belief.change_mean_m));
  for (const double positive :
       {update.belief.change_std_m, update.belief.alpha, update.belief.beta}) {
    EXPECT_TRUE(std::isfinite(positive) && positive > 0.0) << positive;
  }
  EXPECT_GE(update.inlier_probability, 0.0);
  EXPECT_LE(update.inlier_probability, 1.0);
}

TEST(InitialBelief, HasTheStationarityAskedFor) {
  const Belief belief = InitialBelief(0.67);
  EXPECT_DOUBLE_EQ(belief.stationarity(), 0.67);
  EXPECT_DOUBLE_EQ(belief.alpha + belief.beta, 3.0);
  EXPECT_EQ(belief.change_mean_m, 0.0);
  EXPECT_EQ(belief.change_std_m, 0.5);
}

TEST(UpdateStationarity, KeepsTheMomentsOfTheExactPosterior) {
  std::mt19937 random(1);
  const auto uniform = [&random](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  int inliers = 0;
  for (int round = 0; round < 150; ++round) {
    const Belief prior{uniform(-1.0, 1.0), uniform(0.1, 0.8), uniform(0.7, 12), uniform(0.7, 12)};
    StationarityParameters parameters = PublishedParameters();
    parameters.change_noise_m = uniform(0.1, 0.4);
    parameters.max_change_m = uniform(1.0, 4.0);
    parameters.class_weight = uniform(0.0, 4.0);
    const double change_m = uniform(-parameters.max_change_m, parameters.max_change_m);
    SCOPED_TRACE(::testing::Message() << "round " << round);
    for (const StationarityPrior class_prior :
         {StationarityPrior::kMobile, StationarityPrior::kStationary}) {
      const StationarityUpdate update =
          UpdateStationarity(prior, change_m, class_prior, parameters);
      ExpectSameMoments(ExactMoments(prior, change_m, class_prior, parameters), MomentsOf(update));
      ASSERT_FALSE(HasFailure());
      if (update.inlier_probability > 0.5) ++inliers;
    }
  }
  EXPECT_GT(inliers, 60);
  EXPECT_LT(inliers, 240);
}

TEST(UpdateStationarity, AgreesWithTheFormulasAsPrinted) {
  const Belief prior{0.1, 0.3, 4.0, 2.0};
  const StationarityParameters parameters = PublishedParameters();
  const StationarityUpdate update =
      UpdateStationarity(prior, 0.9, StationarityPrior::kMobile, parameters);
  // k = 0: an object of a mobile class was observed in place.
  const double c1 = update.inlier_probability;
  ASSERT_GT(c1, 0.5);
  const double n = 6.0;
  const double e1 = (4.0 + c1) / (n + 1.0);
  const double e2 = 5.0 * (4.0 + 2.0 * c1) / ((n + 1.0) * (n + 2.0));
  const double evidence = (e1 - e2) / (e2 - e1 * e1);
  EXPECT_NEAR(update.belief.alpha, e1 * evidence, 1e-9);
  EXPECT_NEAR(update.belief.beta, (1.0 - e1) * evidence, 1e-9);
}

TEST(UpdateStationarity, RepeatedZeroChangeRaisesStationarityUpToItsMaximum) {
  for (const StationarityPrior class_prior :
       {StationarityPrior::kMobile, StationarityPrior::kStationary}) {
    const StationarityParameters parameters;
    Belief belief = InitialBelief(0.67);
    for (int i = 0; i < 1000; ++i) {
      const Belief updated = UpdateStationarity(belief, 0.0, class_prior, parameters).belief;
      ASSERT_GE(updated.stationarity(), belief.stationarity()) << i;
      ASSERT_LE(updated.stationarity(), parameters.max_stationarity) << i;
      if (i < 20) {
        ASSERT_GT(updated.stationarity(), belief.stationarity()) << i;
        ASSERT_LT(updated.change_std_m, belief.change_std_m) << i;
      }
      belief = updated;
    }
    EXPECT_GT(belief.stationarity(), 0.999);
  }
}

TEST(UpdateStationarity, RepeatedOutliersLowerStationarity) {
  for (const StationarityPrior class_prior :
       {StationarityPrior::kMobile, StationarityPrior::kStationary}) {
    Belief belief = InitialBelief(0.67);
    for (int i = 0; i < 50; ++i) {
      const StationarityUpdate update = UpdateStationarity(belief, 4.0, class_prior, {});
      ASSERT_LT(update.belief.stationarity(), belief.stationarity()) << i;
      ASSERT_LT(update.inlier_probability, 1e-6) << i;
      belief = update.belief;
    }
    EXPECT_LT(belief.stationarity(), 0.05);
  }
}

TEST(UpdateStationarity, ClassCountsOnlyWhereItAgrees) {
  const Belief prior = InitialBelief(0.67);
  StationarityParameters silent;
  silent.class_weight = 0.0;
  for (const double change_m : {0.0, 4.0}) {
    const StationarityUpdate stays =
        UpdateStationarity(prior, change_m, StationarityPrior::kStationary, {});
    const StationarityUpdate moves =
        UpdateStationarity(prior, change_m, StationarityPrior::kMobile, {});
    const StationarityUpdate neither =
        UpdateStationarity(prior, change_m, StationarityPrior::kStationary, silent);
    if (change_m == 0.0) {
      EXPECT_GT(stays.belief.stationarity(), neither.belief.stationarity());
      EXPECT_GT(stays.inlier_probability, neither.inlier_probability);
      EXPECT_EQ(moves.belief, neither.belief);
    } else {
      EXPECT_LT(moves.belief.stationarity(), neither.belief.stationarity());
      EXPECT_LT(moves.inlier_probability, neither.inlier_probability);
      EXPECT_EQ(stays.belief, neither.belief);
    }
  }
}

TEST(UpdateStationarity, CapKeepsTheRatioAndLetsALongKnownObjectChange) {
  StationarityParameters capped;
  capped.max_evidence = 10.0;
  Belief belief = InitialBelief(0.67);
  Belief uncapped = belief;
  for (int i = 0; i < 100; ++i) {
    const StationarityUpdate free =
        UpdateStationarity(belief, 0.05, StationarityPrior::kMobile, PublishedParameters());
    belief = UpdateStationarity(belief, 0.05, StationarityPrior::kMobile, capped).belief;
    EXPECT_NEAR(belief.stationarity(), free.belief.stationarity(), 1e-14);
    EXPECT_LE(belief.alpha + belief.beta, 10.0 + 1e-12);
    uncapped = UpdateStationarity(uncapped, 0.05, StationarityPrior::kMobile, PublishedParameters())
                   .belief;
  }
  EXPECT_NEAR(belief.alpha + belief.beta, 10.0, 1e-12);
  EXPECT_GT(uncapped.alpha + uncapped.beta, 50.0);
  const Belief after = UpdateStationarity(belief, 4.0, StationarityPrior::kMobile, capped).belief;
  EXPECT_LT(after.stationarity(), belief.stationarity() - 0.1);
}

TEST(UpdateStationarity, SkipsWhatWouldRaiseStationarityBeyondItsMaximum) {
  StationarityParameters parameters;
  parameters.max_stationarity = 0.7;
  const Belief low{0.1, 0.4, 6.8, 3.2};
  const StationarityUpdate skipped =
      UpdateStationarity(low, 0.0, StationarityPrior::kStationary, parameters);
  EXPECT_EQ(skipped.belief, low);
  EXPECT_GT(skipped.inlier_probability, 0.5);
  // A belief above the maximum can still decrease.
  const Belief high{0.1, 0.4, 9.0, 1.0};
  EXPECT_LT(UpdateStationarity(high, 4.0, StationarityPrior::kStationary, parameters)
                .belief.stationarity(),
            0.9);
}

TEST(UpdateStationarity, ChangeBeyondTheMaximumCountsAsTheMaximum) {
  const Belief prior{-0.5, 2.0, 2.0, 1.0};
  for (const double sign : {-1.0, 1.0}) {
    const StationarityUpdate at =
        UpdateStationarity(prior, sign * 4.0, StationarityPrior::kMobile, {});
    for (const double change_m : {4.1, 1e300, kInfinity}) {
      EXPECT_EQ(UpdateStationarity(prior, sign * change_m, StationarityPrior::kMobile, {}).belief,
                at.belief);
    }
  }
}

TEST(UpdateStationarity, SharpBeliefsKeepTheirVariance) {
  // With the printed formula e2 - e1^2, the variance of this Beta would lose its last five digits.
  const Belief prior{0.0, 0.5, 6e10, 4e10};
  const Belief after =
      UpdateStationarity(prior, 0.0, StationarityPrior::kMobile, PublishedParameters()).belief;
  EXPECT_NEAR((after.alpha + after.beta) / (prior.alpha + prior.beta), 1.0, 1e-9);
}

TEST(UpdateStationarity, AnyFiniteInputGivesAProperBelief) {
  std::mt19937 random(2);
  const std::vector<double> extremes{std::numeric_limits<double>::denorm_min(),
                                     std::numeric_limits<double>::min(),
                                     1e-200,
                                     1e-60,
                                     1e-16,
                                     1e60,
                                     1e200,
                                     std::numeric_limits<double>::max()};
  const auto positive = [&] {
    if (random() % 3 == 0) return extremes[random() % extremes.size()];
    return std::exp(std::uniform_real_distribution<double>(-30.0, 30.0)(random));
  };
  const auto any = [&] { return random() % 2 == 0 ? positive() : -positive(); };
  for (int round = 0; round < 50'000; ++round) {
    StationarityUpdate update{{any(), positive(), positive(), positive()}, 0.0};
    StationarityParameters parameters;
    if (round % 2 == 0) {
      parameters = {positive(), positive(), positive(), 2.0 + positive(), 0.99};
    }
    for (int step = 0; step < 4; ++step) {
      const auto class_prior = static_cast<StationarityPrior>(random() % 2);
      update = UpdateStationarity(update.belief, any(), class_prior, parameters);
      ExpectProper(update);
    }
    ASSERT_FALSE(HasFailure()) << "round " << round;
  }
}

}  // namespace
}  // namespace steadymap
