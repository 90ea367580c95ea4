#pragma once

namespace steadymap {

/// Shares of a surface that decide. They are the same wherever two surfaces are compared.
struct SurfaceShares {
  /// A smaller share tells nothing: errors of depth, poses, labels and registration explain it.
  double negligible = 0.15;
  /// A share that is known, hidden, or in common with another surface tells something from here on.
  double substantial = 0.3;
  /// A share that decides on the whole: it is gone, or it is recognised elsewhere.
  double majority = 0.5;

  /// All but less than a substantial share.
  double most() const { return 1.0 - substantial; }

  /// All but a negligible share.
  double nearly_all() const { return 1.0 - negligible; }

  friend bool operator==(const SurfaceShares&, const SurfaceShares&) = default;
};

}  // namespace steadymap
