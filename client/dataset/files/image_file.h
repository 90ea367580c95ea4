#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "core/frame/image_codec.h"
#include "core/geometry/geometry.h"

namespace steadymap {

/// Largest size of an image file that is read.
inline constexpr std::size_t kMaxImageFileBytes = std::size_t{64} << 20;

/// Checks that an image has the size of the camera's images. Errors: `InvalidArgument` with the
/// file, the expected size and the actual size in the message.
absl::Status CheckImageSize(const std::filesystem::path& file,
                            const PinholeCamera& camera,
                            const ImageSize& size);

/// An image file in memory, not decoded.
struct ImageFile {
  std::string data;     ///< The file's bytes.
  bool is_png = false;  ///< False: a JPEG.
  ImageSize size;       ///< Size in the image header.
};

/// Reads a PNG or JPEG file of at most `kMaxImageFileBytes`. Parses only its header. Errors:
/// `NotFound` or `InvalidArgument`, with the file in the message.
absl::StatusOr<ImageFile> ReadImageFile(const std::filesystem::path& file);

/// Reads an image that must have the size of the camera's images. Errors: as for `ReadImageFile`,
/// and as `CheckImageSize`.
absl::StatusOr<ImageFile> ReadImageFile(const std::filesystem::path& file,
                                        const PinholeCamera& camera);

/// Reads an image that must be a PNG and have the size of the camera's images. Errors: as for
/// `ReadImageFile`, and as `CheckImageSize`.
absl::StatusOr<ImageFile> ReadPngFile(const std::filesystem::path& file,
                                      const PinholeCamera& camera);

}  // namespace steadymap
