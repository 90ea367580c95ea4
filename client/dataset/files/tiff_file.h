#pragma once

#include <filesystem>

#include <absl/status/statusor.h>

#include "core/frame/frame.h"

namespace steadymap {

/// Reads the first image of a TIFF file of at most `kMaxImageFileBytes`: one channel of 32-bit
/// floats, in strips, any compression. Compares the size with the camera's before it decodes any
/// pixel. Errors: `NotFound` or `InvalidArgument`, with the file in the message.
absl::StatusOr<Image<float>> ReadTiffFile(const std::filesystem::path& file,
                                          const PinholeCamera& camera);

}  // namespace steadymap
