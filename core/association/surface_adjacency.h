#pragma once

#include <cstdint>
#include <vector>

#include "core/association/association.h"
#include "core/association/sample_grid.h"

namespace steadymap {

/// Two objects whose surfaces are connected in a frame.
struct Contact {
  std::uint32_t first = 0;  ///< Owners as in `Association::owner`; first < second.
  std::uint32_t second = 0;
  std::size_t samples = 0;  ///< Pairs of neighbouring samples that are connected.
};

/// All contacts between objects, by rising owners; none between objects of which the frame's
/// instance ids say that they are two.
std::vector<Contact> FindSurfaceAdjacencies(const SampleGrid& samples,
                                            const Association& association);

}  // namespace steadymap
