#pragma once

#include <cstdint>
#include <string>

#include "core/frame/frame.h"
#include "core/types/map_config.h"

namespace steadymap {

/// A map and a frame that pass every check of the service, close to the limits of those checks.
struct LegalFrame {
  MapConfig config;
  Frame frame;
  std::string description;  ///< One line, for failure messages.
};

/// Generates a random legal map and frame: any policy, voxels of 1 mm to 1 m, any legal truncation,
/// depth up to 100 m, images up to `max_side_px`, any field of view; walls, slopes, combs and
/// noise, without labels or with up to one object per pixel.
LegalFrame RandomLegalFrame(std::uint64_t seed, int max_side_px);

}  // namespace steadymap
