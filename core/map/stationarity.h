#pragma once

/// What is believed of one object, and how a measurement changes it: the Gaussian-Beta state of
/// POCD (pocd.md section 4; Qian et al., RSS 2022, supplement equations 17 to 23).
namespace steadymap {

/// `q(l, v) = N(l | change_mean_m, change_std_m^2) Beta(v | alpha, beta)`: `l` is how far the
/// object's surface has moved since it was mapped, positive towards the camera that measured it,
/// `v` in [0, 1] whether it stands where it stood.
struct Belief {
  double change_mean_m = 0.0;
  double change_std_m = 0.5;  ///< > 0.
  double alpha = 1.0;         ///< > 0.
  double beta = 1.0;          ///< > 0.

  /// Expected stationarity, E[v].
  double stationarity() const { return alpha / (alpha + beta); }

  friend bool operator==(const Belief&, const Belief&) = default;
};

/// Whether things of a class are expected to stay, the measurement `s` of the paper.
enum class StationarityPrior {
  kMoves,  ///< s = 0: contradictions count more.
  kStays,  ///< s = 1: agreement counts more.
};

/// The constants of the update. Defaults: TorWIC (pocd.md section 5).
struct StationarityParameters {
  /// Standard deviation of a measured change while the object stands still (tau), metres, > 0.
  double change_noise_m = 0.2;
  /// Changes lie within plus and minus this (delta_max), metres, > 0.
  double max_change_m = 4.0;
  /// How much the class says (k), >= 0; 0: nothing.
  double class_weight = 3.0;
  /// alpha + beta is scaled down to this, so that a long-known object can still change, > 2.
  /// Infinity: the paper, which has no cap.
  double max_evidence = 15.0;
  /// E[v] is not raised beyond this, in (0, 1).
  double max_stationarity = 0.9999;

  friend bool operator==(const StationarityParameters&, const StationarityParameters&) = default;
};

/// The belief of an object just mapped: nothing has moved yet.
/// `stationarity` is E[v] at first, in (0, 1); alpha + beta is 3.
Belief InitialBelief(double stationarity);

/// What a measurement did to a belief.
struct StationarityUpdate {
  Belief belief;
  /// Posterior probability that the measurement came from an object that stands still (c1).
  double inlier_probability = 0.0;
};

/// The belief after a change of `change_m` was measured (pocd.md section 4); magnitudes beyond the
/// maximum count as the maximum. The class counts only where it agrees: a thing that stays was seen
/// in place, or one that moves was contradicted. An update that would raise E[v] beyond its maximum
/// is skipped: the prior comes back.
///
/// Any finite prior with positive `change_std_m`, `alpha` and `beta` gives another such belief. In
/// doing so magnitudes are confined to [1e-50, 1e50].
StationarityUpdate UpdateStationarity(const Belief& prior,
                                      double change_m,
                                      StationarityPrior class_prior,
                                      const StationarityParameters& parameters);

}  // namespace steadymap
