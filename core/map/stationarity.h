#pragma once

#include "core/types/identifiers.h"
#include "core/types/map_config.h"

/// The belief of an object and its update by a measurement: the Gaussian-Beta state of POCD (Qian
/// et al., RSS 2022, supplement, equations 17 to 23).
namespace steadymap {

/// The distribution `q(l, v) = N(l | change_mean_m, change_std_m^2) Beta(v | alpha, beta)`. `l` is
/// the displacement of the object's surface since it was mapped, metres, positive towards the
/// measuring camera. `v` in [0, 1] is the stationarity, whether the object is at its mapped place.
struct Belief {
  double change_mean_m = 0.0;
  double change_std_m = 0.5;  ///< > 0.
  double alpha = 1.0;         ///< > 0.
  double beta = 1.0;          ///< > 0.

  /// Returns the expected stationarity, E[v].
  double stationarity() const { return alpha / (alpha + beta); }

  friend bool operator==(const Belief&, const Belief&) = default;
};

/// Whether objects of a class are expected to be stationary, the measurement `s` of Qian et al.,
/// RSS 2022.
enum class StationarityPrior {
  kMobile,      ///< s = 0: contradictions have more weight.
  kStationary,  ///< s = 1: agreement has more weight.
};

/// The constants of the update and of its likelihood. Defaults: TorWIC (Qian et al., RSS 2022),
/// except `max_evidence`.
struct StationarityParameters {
  /// Standard deviation of the measured change of a stationary object (tau), metres, > 0.
  double change_noise_m = 0.2;
  /// Largest magnitude of a change (delta_max), metres, > 0.
  double max_change_m = 4.0;
  /// Weight of the class (k), >= 0. 0: the class has no effect.
  double class_weight = 3.0;
  /// alpha + beta is scaled down to this value, > 2, so that the belief of a long-known object can
  /// still change. Infinity: no limit, as in Qian et al., RSS 2022.
  double max_evidence = 15.0;
  /// An update does not raise E[v] above this value, in (0, 1).
  double max_stationarity = 0.9999;

  friend bool operator==(const StationarityParameters&, const StationarityParameters&) = default;
};

/// Returns what a class says about stationarity. Objects of unlisted classes are expected to be
/// stationary.
StationarityPrior PriorOf(const MapConfig& config, ClassId class_id);

/// Returns the belief of a newly mapped object: no change yet. `stationarity` is the initial E[v],
/// in (0, 1); alpha + beta is 3.
Belief InitialBelief(double stationarity);

/// The result of a belief update.
struct StationarityUpdate {
  Belief belief;
  /// Posterior probability that the measured object is stationary (c1).
  double inlier_probability = 0.0;
};

/// Updates a belief with the measured change `change_m`, whose magnitude is limited to
/// `max_change_m` (Qian et al., RSS 2022, supplement, equations 17 to 23). The class has an effect
/// only in agreement with the measurement: an inlier of a stationary class, or an outlier of
/// another class. An update that would raise E[v] above `max_stationarity` is skipped and returns
/// the prior.
///
/// A finite prior with positive `change_std_m`, `alpha` and `beta` gives a belief with the same
/// properties. Magnitudes are limited to [1e-50, 1e50].
StationarityUpdate UpdateStationarity(const Belief& prior,
                                      double change_m,
                                      StationarityPrior class_prior,
                                      const StationarityParameters& parameters);

}  // namespace steadymap
