#pragma once

namespace steadymap {

/// Thresholds for shares of a surface, the same wherever a session compares two surfaces.
struct SurfaceShares {
  /// A smaller share is no evidence: errors of depth, poses, labels and registration explain it.
  double negligible = 0.15;
  /// From this share on, it counts that a surface is known, occluded or also that of another
  /// object.
  double substantial = 0.3;
  /// From this share on, a part decides for the whole object: it is gone, or recognised elsewhere.
  double majority = 0.5;

  /// All but less than a substantial share.
  double most() const { return 1.0 - substantial; }

  /// All but a negligible share.
  double nearly_all() const { return 1.0 - negligible; }

  friend bool operator==(const SurfaceShares&, const SurfaceShares&) = default;
};

}  // namespace steadymap
