#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/association/sample_grid.h"
#include "core/integration/semantic_cloud.h"
#include "core/types/map_config.h"

namespace steadymap {

/// A connected part of the surface that one frame shows, of one class or of one instance.
struct FrameSegment {
  std::vector<std::size_t> samples;  ///< Indices into the sample grid, increasing.
  std::uint16_t label = 0;           ///< The most frequent class of its samples.
  std::uint16_t instance = 0;        ///< 0: none.
  double area_m2 = 0.0;
};

/// What a sample can be used for.
enum class SampleUse : std::uint8_t {
  kSegment,
  /// It is surface, but seen at such a flat angle that it does not tell what is connected.
  kSurface,
  kNone,  ///< Its label contradicts the map.
};

/// True if a sample of a frame with labels or instances is of the background: it is of no instance
/// and of a class in the background.
bool IsLabelledBackground(const MapConfig& config, const SurfaceSample& sample);

/// When two neighbouring samples are on one surface.
struct ContinuityParameters {
  /// Distance of each sample from the plane of the other one, in standard deviations of the
  /// difference of two depths.
  double max_sigmas = 3.0;
  /// Samples of surface at a flatter angle to the ray are too far apart to show what is connected.
  double min_facing_cosine = 0.4;
  /// Segments of fewer samples are fragments at depth edges.
  std::size_t min_samples = 6;

  friend bool operator==(const ContinuityParameters&, const ContinuityParameters&) = default;
};

/// Divides the valid samples of a frame, those of `cloud`, whose use is `kSegment`, into segments.
/// Neighbours are of one segment if they have one instance, or else one class, and no gap in depth
/// is between them. A sample with the use `kSurface` joins an adjacent segment of its instance.
/// Returns the segments in the order of their first samples with the use `kSegment`.
std::vector<FrameSegment> FindFrameSegments(const SemanticCloud& cloud,
                                            const SampleGrid& samples,
                                            const std::vector<SampleUse>& uses,
                                            const ContinuityParameters& parameters);

}  // namespace steadymap
