#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/association/association.h"
#include "core/association/observation.h"
#include "core/association/sample_grid.h"
#include "core/integration/semantic_cloud.h"

namespace steadymap {

/// When a segment shows an object, as far as the picture tells.
struct OverlapParameters {
  /// Samples that both cover, of those that either covers, must exceed this, in [0, 1].
  double min_overlap = 0.1;
  /// Both cover a sample only if their depths differ by no more than this, metres.
  double depth_tolerance_m = 0.1;
};

/// For each segment the object of its class that it overlaps best when both are drawn into the
/// picture, as a place among `objects`; none if that is too little. Several segments may show parts
/// of one object. Its occlusion by other objects is not counted against it.
///
/// Cost: about 50 ns a surface point in view.
std::vector<std::optional<std::size_t>> MatchByOverlap(const std::vector<Observation>& segments,
                                                       const std::vector<ObjectInView>& objects,
                                                       const SemanticCloud& cloud,
                                                       const SampleGrid& samples,
                                                       const VoxelScale& scale,
                                                       const OverlapParameters& parameters);

}  // namespace steadymap
