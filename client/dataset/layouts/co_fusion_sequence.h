#pragma once

#include "client/dataset/layouts/recorded_sequence.h"

namespace steadymap {

/// Co-Fusion. Masks serve as instances, and as classes that a label map turns into the map's. Its
/// world is wherever the first camera pose puts it; `T_world_dataset` of the options sets it
/// upright.
DatasetFormat CoFusionFormat();

}  // namespace steadymap
