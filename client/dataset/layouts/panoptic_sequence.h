#pragma once

#include "client/dataset/layouts/recorded_sequence.h"

namespace steadymap {

/// Returns the format of the Panoptic Mapping flat data set. Its world frame has z up. Segments are
/// used as instances; segment 0 is no instance.
DatasetFormat PanopticFormat();

}  // namespace steadymap
