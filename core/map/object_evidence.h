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
  /// By evidence cell: the balance of the looks that found its surface and of those that did not,
  /// limited on either side (`LookParameters::max_score`).
  std::array<std::int8_t, kEvidenceCells> score{};
  Timestamp last_look;  ///< Capture time of the last frame that counted.

  friend bool operator==(const LeafEvidence&, const LeafEvidence&) = default;
};

/// The evidence for an object: of the open session by leaf, and of the last session in sums.
struct ObjectEvidence {
  double present_cells = 0.0;        ///< Evidence cells that were found in the last session.
  double absent_cells = 0.0;         ///< Evidence cells that were gone in the last session.
  std::vector<LeafEvidence> leaves;  ///< By increasing origin.

  /// Returns the evidence of a leaf; creates it if it does not exist.
  LeafEvidence& MutableLeaf(LeafOrigin origin);

  /// Returns the evidence of a leaf; null if it does not exist.
  const LeafEvidence* FindLeaf(LeafOrigin origin) const;

  friend bool operator==(const ObjectEvidence&, const ObjectEvidence&) = default;
};

}  // namespace steadymap
