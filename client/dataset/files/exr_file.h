#pragma once

#include <filesystem>

#include <absl/status/statusor.h>

#include "core/frame/frame.h"

namespace steadymap {

/// Reads one channel of an OpenEXR file of at most `kMaxImageFileBytes`: scan lines, half or float,
/// any compression. Of several channels it is the first there is of Z, Y, V and R, else the first
/// that is not alpha. The size is compared with the camera's before any pixel is decoded. Errors:
/// `NotFound` or `InvalidArgument`, naming the file.
absl::StatusOr<Image<float>> ReadExrFile(const std::filesystem::path& file,
                                         const PinholeCamera& camera);

}  // namespace steadymap
