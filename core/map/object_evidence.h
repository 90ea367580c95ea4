#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/map/object_surface.h"
#include "core/types/timestamp.h"
#include "core/volume/voxel_leaf.h"

namespace steadymap {

/// The evidence for the surface of one leaf of an object.
struct LeafEvidence {
  LeafOrigin origin;
  /// By evidence cell. A frame that observes the surface of the cell raises its score by one, at
  /// least to -1 and at most to `kMaxCellScore`. A frame that contradicts the cell lowers it by
  /// one, down to `kMinCellScore`.
  std::array<std::int8_t, kEvidenceCells> score{};
  Timestamp confirmed;  ///< Last presence evidence, rounded so that static objects do not change.

  friend bool operator==(const LeafEvidence&, const LeafEvidence&) = default;
};

/// Minimum interval between two updates of `LeafEvidence::confirmed`. It keeps the state of a
/// static object constant.
inline constexpr Duration kConfirmationGrain = Duration::FromNanoseconds(2'000'000'000);

inline constexpr std::int8_t kMaxCellScore = 3;
inline constexpr std::int8_t kMinCellScore = -100;

/// The evidence for an object since the last update of its belief, and for each part of its
/// surface.
struct ObjectEvidence {
  double present_cells = 0.0;  ///< Presence evidence since the last update, evidence cells.
  double absent_cells = 0.0;   ///< Absence evidence since the last update, evidence cells.
  /// Absence evidence since the last frame with more presence than absence evidence, evidence
  /// cells.
  double absent_streak_cells = 0.0;
  /// Sum over the frames since the last update of the change estimate, metres, times the number of
  /// evidence cells found present.
  double change_sum_m = 0.0;
  std::vector<LeafEvidence> leaves;  ///< By increasing origin.

  /// Returns the time of the last presence evidence for a leaf; the epoch if there is none.
  Timestamp ConfirmedAt(LeafOrigin origin) const;

  /// Returns the time of the last presence evidence for any leaf; the epoch if there is none.
  Timestamp LastConfirmed() const;

  /// Returns the evidence of a leaf; creates it if it does not exist.
  LeafEvidence& MutableLeaf(LeafOrigin origin);

  /// Returns the evidence of a leaf; null if it does not exist.
  const LeafEvidence* FindLeaf(LeafOrigin origin) const;

  friend bool operator==(const ObjectEvidence&, const ObjectEvidence&) = default;
};

}  // namespace steadymap
