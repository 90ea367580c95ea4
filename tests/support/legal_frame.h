#pragma once

#include <cstdint>
#include <string>

#include "core/frame/frame.h"
#include "core/types/map_config.h"

namespace steadymap {

/// A map and a frame that pass every check of the service, at the limits of those checks.
struct LegalFrame {
  MapConfig config;
  Frame frame;
  std::string description;  ///< One line, for people.
};

/// Draws one of them at random: any policy, voxels of 1 mm to 1 m, the narrowest to the widest
/// truncation, depth up to 100 m, images up to `max_side_px`, telephoto to nearly flat cameras;
/// walls, slopes, combs and noise, without labels or with every pixel a thing of its own.
LegalFrame RandomLegalFrame(std::uint64_t seed, int max_side_px);

}  // namespace steadymap
