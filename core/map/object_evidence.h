#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/map/object_surface.h"
#include "core/types/identifiers.h"
#include "core/types/timestamp.h"
#include "core/volume/voxel_leaf.h"

namespace steadymap {

/// The evidence for the surface of one leaf of an object.
struct LeafEvidence {
  LeafOrigin origin;
  /// By evidence cell: the balance of the looks that found its surface and of those that did not,
  /// limited on either side (`LookParameters::confirming_looks`).
  std::array<std::int8_t, kEvidenceCells> score{};
  Timestamp last_look;  ///< Capture time of the last frame that counted.

  friend bool operator==(const LeafEvidence&, const LeafEvidence&) = default;
};

/// The evidence for an object: by leaf of its own session or, of a known object, of the session
/// that is decided; of the last session in sums.
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

/// The evidence of one open session for a known object.
struct SessionLooks {
  SensorName source;
  std::vector<LeafEvidence> leaves;  ///< By increasing origin.

  friend bool operator==(const SessionLooks&, const SessionLooks&) = default;
};

/// Returns the capture time of the last look at any of the leaves; 1970 without leaves.
Timestamp LastLook(const std::vector<LeafEvidence>& leaves);

/// Largest number of open sessions whose looks at one object are kept; of more, those with the
/// oldest last looks are dropped. Bounds the memory that sessions without an end take.
inline constexpr std::size_t kMaxLookingSessions = 8;

/// Returns the leaves of a source and removes them; none if it has not looked. `looks`: by
/// increasing source.
std::vector<LeafEvidence> TakeLooks(const SensorName& source, std::vector<SessionLooks>* looks);

/// Stores the leaves of a source, which has none in `looks`.
void StoreLooks(const SensorName& source,
                std::vector<LeafEvidence> leaves,
                std::vector<SessionLooks>* looks);

}  // namespace steadymap
