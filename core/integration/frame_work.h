#pragma once

#include <cstddef>

#include <absl/status/status.h>

#include "core/frame/frame.h"
#include "core/types/map_config.h"

namespace steadymap {

/// Maximum number of leaves (8 x 8 x 8 voxels) touched by a frame: about half a second of work and
/// 300 MB. Typical frames touch hundreds to a few thousand leaves.
inline constexpr std::size_t kMaxFrameLeaves = 65'536;

/// Maximum number of leaves changed by one frame in all volumes of background and objects together.
inline constexpr std::size_t kMaxFusedLeaves = 2 * kMaxFrameLeaves;

/// Estimates the number of leaves that the integration of a frame touches: the leaves within the
/// truncation distance of the observed surface, on the assumption that every surface faces the
/// camera. Stops soon after the count exceeds `limit`. Cost: one ray per 16 pixels; up to one per
/// pixel if the estimate is near or above `limit`.
std::size_t EstimateTouchedLeaves(const Frame& frame, const MapConfig& config, std::size_t limit);

/// Returns OK if the work to integrate the frame into a map of this configuration is bounded.
/// Errors: `InvalidArgument` with reason `FRAME_TOO_FINE` and the field `depth`.
absl::Status CheckFrameWork(const Frame& frame, const MapConfig& config);

}  // namespace steadymap
