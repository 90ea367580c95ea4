#pragma once

#include <filesystem>

#include <absl/status/statusor.h>

#include "core/frame/frame.h"

namespace steadymap {

/// Reads the first image of a TIFF file of at most `kMaxImageFileBytes`: one channel of 32-bit
/// floats, in strips, any compression. The size is compared with the camera's before any pixel is
/// decoded. Errors: `NotFound` or `InvalidArgument`, naming the file.
absl::StatusOr<Image<float>> ReadTiffFile(const std::filesystem::path& file,
                                          const PinholeCamera& camera);

}  // namespace steadymap
