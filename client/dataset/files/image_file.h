#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "core/frame/image_codec.h"
#include "core/geometry/geometry.h"

namespace steadymap {

/// Largest image file that is read.
inline constexpr std::size_t kMaxImageFileBytes = std::size_t{64} << 20;

/// OK if an image is as large as the camera says; else `InvalidArgument` naming the file, the size
/// expected and the size found.
absl::Status CheckImageSize(const std::filesystem::path& file,
                            const PinholeCamera& camera,
                            const ImageSize& size);

/// An image as it lies on disk.
struct ImageFile {
  std::string data;     ///< The file's bytes.
  bool is_png = false;  ///< Else it is a JPEG.
  ImageSize size;       ///< What its header declares.
};

/// Reads a PNG or JPEG file of at most `kMaxImageFileBytes`; only its header is looked at.
/// Errors: `NotFound` or `InvalidArgument`, naming the file.
absl::StatusOr<ImageFile> ReadImageFile(const std::filesystem::path& file);

/// As `ReadImageFile`, for an image that must be as large as the camera says.
/// Errors: also `InvalidArgument` naming the file, the size expected and the size found.
absl::StatusOr<ImageFile> ReadImageFile(const std::filesystem::path& file,
                                        const PinholeCamera& camera);

/// As above, for an image that must be a PNG.
absl::StatusOr<ImageFile> ReadPngFile(const std::filesystem::path& file,
                                      const PinholeCamera& camera);

}  // namespace steadymap
