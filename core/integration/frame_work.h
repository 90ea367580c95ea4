#pragma once

#include <cstddef>

#include <absl/status/status.h>

#include "core/frame/frame.h"
#include "core/types/map_config.h"

namespace steadymap {

/// Leaves of 8 x 8 x 8 voxels that one frame may touch: about half a second of work and 300 MB.
/// An ordinary frame touches some hundreds to some thousands.
inline constexpr std::size_t kMaxFrameLeaves = 65'536;

/// Leaves that the volumes of background and objects take from one frame, together.
inline constexpr std::size_t kMaxFusedLeaves = 2 * kMaxFrameLeaves;

/// About the number of leaves that integrating a frame touches: those within the truncation of what
/// its depth image shows, as if every surface faced the camera. Counts no further than past
/// `limit`. Cost: that of a sixteenth of the pixels, or of all where these are too many.
std::size_t EstimateTouchedLeaves(const Frame& frame, const MapConfig& config, std::size_t limit);

/// OK if a map of this configuration can integrate the frame with bounded work. Errors:
/// `InvalidArgument` with reason `FRAME_TOO_FINE` and the field `depth`.
absl::Status CheckFrameWork(const Frame& frame, const MapConfig& config);

}  // namespace steadymap
