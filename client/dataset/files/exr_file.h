#pragma once

#include <filesystem>

#include <absl/status/statusor.h>

#include "core/frame/frame.h"

namespace steadymap {

/// Reads one channel of an OpenEXR file of at most `kMaxImageFileBytes`: scan lines, half or float,
/// any compression. Chooses the first existing channel of Z, Y, V and R, otherwise the first
/// channel that is not alpha. Compares the size with the camera's before it decodes any pixel.
/// Errors: `NotFound` or `InvalidArgument`, with the file in the message.
absl::StatusOr<Image<float>> ReadExrFile(const std::filesystem::path& file,
                                         const PinholeCamera& camera);

}  // namespace steadymap
