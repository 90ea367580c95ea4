#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>

#include <absl/status/status.h>

#include "client/bench/simulator/simulation.h"

namespace steadymap {

/// Writes a route as recordings in the TorWIC-Mapping layout: in `directory` a folder for each
/// sequence (`01-baseline`, `02-1-5`, ...) with `Depth/`, `Segmentation/`, `Instances/` and `RGB/`
/// where the options ask for them, `poses.txt` and `calibration.txt`. What the loader reads from it
/// equals what the simulation renders.
///
/// `directory` is created where it is missing; files in it are overwritten. `on_frame`, if given,
/// is called after each frame with the number written so far.
/// Errors: the status of the first file that cannot be written, naming it.
absl::Status WriteTorwicFolder(const Route& route,
                               const std::filesystem::path& directory,
                               const SimulationOptions& options,
                               const std::function<void(std::size_t)>& on_frame = {});

}  // namespace steadymap
