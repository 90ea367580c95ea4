#pragma once

#include "client/dataset/layouts/recorded_sequence.h"

namespace steadymap {

/// The flat of panoptic mapping: its world has z up. Segments serve as instances, 0 being none.
DatasetFormat PanopticFormat();

}  // namespace steadymap
