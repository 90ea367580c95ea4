#pragma once

#include <cstdint>
#include <vector>

#include "core/association/association.h"
#include "core/association/sample_grid.h"

namespace steadymap {

/// Connected surface of one class in a frame (core/README.md#terms).
struct Observation {
  std::vector<std::size_t> samples;  ///< Indices into the grid, in the order they were found.
  std::uint16_t label = 0;
  std::uint16_t instance = 0;
  double area_m2 = 0.0;
};

/// Largest number of observations of one frame; bounds the cost of their association. Frames of the
/// simulated routes had at most 198, those of a real kitchen 327 (185 on average), most of them
/// noise of a sample or two.
inline constexpr std::size_t kMaxObservations = 1024;

/// Keeps the `kMaxObservations` observations with the most samples, the first of equals, in their
/// order.
void KeepLargest(std::vector<Observation>* observations);

/// Groups the samples that have no owner. Samples with instance ids group by instance instead of
/// class. In the order of their first sample; the largest `kMaxObservations` if there are more.
std::vector<Observation> FindObservations(const SampleGrid& samples,
                                          const Association& association);

}  // namespace steadymap
