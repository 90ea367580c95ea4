#pragma once

#include "core/map_config.h"
#include "core/sample_grid.h"
#include "core/semantic_cloud.h"
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
