#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/objects/surface_parts.h"

namespace steadymap {

/// When two surfaces are opposite sides of one solid.
struct OppositeSideParameters {
  double max_thickness_m = 1.0;
  /// Share of the points of a surface that must have the other one behind them.
  double min_share = 0.3;
  /// Largest angle between surfaces that face alike, as a cosine.
  double min_cosine = 0.5;

  friend bool operator==(const OppositeSideParameters&, const OppositeSideParameters&) = default;
};

/// Returns for each set of points the set whose surface is on the opposite side of the same solid,
/// or the set itself: inwards from at least `min_share` of its points, the first surface is one of
/// the other set that faces away. `parts` has indices into `points`; points of no set hide what is
/// behind them. Points are about `spacing_m` apart.
std::vector<std::size_t> FindOppositeParts(std::span<const OrientedPoint> points,
                                           std::span<const std::vector<std::size_t>> parts,
                                           double spacing_m,
                                           const OppositeSideParameters& parameters);

}  // namespace steadymap
