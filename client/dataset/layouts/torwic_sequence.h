#pragma once

#include "client/dataset/layouts/recorded_sequence.h"

namespace steadymap {

/// Returns the TorWIC-Mapping format: one folder for each sequence, with the images of one camera
/// and its poses.
DatasetFormat TorwicFormat();

}  // namespace steadymap
