#pragma once

#include "core/association/sample_grid.h"
#include "core/integration/semantic_cloud.h"
#include "core/types/map_config.h"
#include "tests/support/analytic_scene.h"

namespace steadymap::testing {

/// The samples of a frame.
inline SampleGrid SamplesOf(const Frame& frame) {
  SemanticCloud cloud{MapConfig()};
  cloud.Compute(frame);
  SampleGrid samples;
  samples.Compute(cloud);
  return samples;
}

/// The samples of one look at a scene.
inline SampleGrid SamplesOf(const Scene& scene, const SceneLook& look) {
  return SamplesOf(RenderScene(scene, look));
}

}  // namespace steadymap::testing
