#pragma once

#include "core/association/sample_grid.h"
#include "core/integration/semantic_cloud.h"
#include "core/types/map_config.h"
#include "tests/support/analytic_scene.h"

namespace steadymap::testing {

/// Returns the samples of a frame.
inline SampleGrid SamplesOf(const Frame& frame) {
  SemanticCloud cloud{MapConfig()};
  cloud.Compute(frame);
  SampleGrid samples;
  samples.Compute(cloud);
  return samples;
}

/// Returns the samples of one view of a scene.
inline SampleGrid SamplesOf(const Scene& scene, const SceneLook& look) {
  return SamplesOf(RenderScene(scene, look));
}

}  // namespace steadymap::testing
