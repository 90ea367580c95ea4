#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/map/object_surface.h"
#include "core/types/timestamp.h"
#include "core/volume/voxel_leaf.h"

namespace steadymap {

/// What frames have said about the surface of one leaf of an object.
struct LeafEvidence {
  LeafOrigin origin;
  /// By evidence cell: rises by one with each frame that finds the surface there, up to
  /// `kMaxCellScore`, falls by one with each that finds it gone.
  std::array<std::int8_t, kEvidenceCells> score{};
  Timestamp confirmed;  ///< When surface of the leaf was last found; coarse, so that it rests.

  friend bool operator==(const LeafEvidence&, const LeafEvidence&) = default;
};

/// Stamps of confirmation are that coarse, so that what rests does not change.
inline constexpr Duration kConfirmationGrain = Duration::FromNanoseconds(2'000'000'000);

inline constexpr std::int8_t kMaxCellScore = 3;
inline constexpr std::int8_t kMinCellScore = -100;

/// What frames have said about an object since its belief was last updated, and about each part of
/// its surface (evidence.md, rules C and D).
struct ObjectEvidence {
  double present_cells = 0.0;  ///< Judged present since the last update.
  double absent_cells = 0.0;   ///< Judged gone since the last update.
  /// Judged gone since more of the surface was last found than missed.
  double absent_streak_cells = 0.0;
  /// Changes measured since the last update, metres, each times the cells it was measured on: those
  /// of `present_cells`.
  double change_sum_m = 0.0;
  std::vector<LeafEvidence> leaves;  ///< By rising origin.

  /// When surface of the leaf was last found; the epoch if never.
  Timestamp ConfirmedAt(LeafOrigin origin) const;

  /// When any surface was last found; the epoch if never.
  Timestamp LastConfirmed() const;

  /// The evidence of a leaf, made if there is none.
  LeafEvidence& MutableLeaf(LeafOrigin origin);

  /// The evidence of a leaf; null if there is none.
  const LeafEvidence* FindLeaf(LeafOrigin origin) const;

  friend bool operator==(const ObjectEvidence&, const ObjectEvidence&) = default;
};

}  // namespace steadymap
