#pragma once

#include "client/dataset/layouts/recorded_sequence.h"

namespace steadymap {

/// Returns the Co-Fusion format. Masks are used as instances, and as classes, which a label map
/// converts to the map's classes. The world frame of a recording is arbitrary: it depends on the
/// first camera pose. `DatasetOptions::T_world_dataset_file` makes its z axis point up.
DatasetFormat CoFusionFormat();

}  // namespace steadymap
