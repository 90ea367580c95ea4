#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>

#include <absl/status/status.h>

#include "client/bench/simulator/simulation.h"

namespace steadymap {

/// Writes a route as recordings in the TorWIC-Mapping layout: in `directory` one folder per
/// sequence (`01-baseline`, `02-1-5`, ...) with `Depth/`, `Segmentation/`, optional `Instances/`
/// and `RGB/`, `poses.txt` and `calibration.txt`. The frames that the loader reads equal the
/// simulated ones.
///
/// Creates `directory` if it is missing; overwrites files in it. `on_frame`, if not empty, is
/// called after each frame with the number of frames written. Errors: the status of the first file
/// that cannot be written, with its name.
absl::Status WriteTorwicFolder(const Route& route,
                               const std::filesystem::path& directory,
                               const SimulationOptions& options,
                               const std::function<void(std::size_t)>& on_frame = {});

}  // namespace steadymap
