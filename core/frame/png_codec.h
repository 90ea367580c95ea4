#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include <absl/status/statusor.h>

#include "core/frame/frame.h"
#include "core/frame/image_expectation.h"

/// Private to the image codecs: PNG by libpng, hardened against hostile files.
///
/// Rejects interlaced files, checksum errors in any chunk, chunks beyond a fixed size, and bytes
/// before or after the image. Skips metadata (text, profiles, gamma).
namespace steadymap {

/// True if `data` starts with the PNG signature.
bool HasPngSignature(std::string_view data);

/// Reads width and height from the header of a PNG file; neither is 0.
absl::Status ReadPngSize(std::string_view data,
                         const ImageExpectation& expectation,
                         int* width_px,
                         int* height_px);

/// Valid bit depths of a single-channel PNG file, per pixel.
enum class PngDepth { k8Or16Bits, k16BitsOnly };

/// Decodes a greyscale PNG file, or the indices of a palette PNG file.
absl::StatusOr<Image<std::uint16_t>> DecodePngPixels(std::string_view data,
                                                     const ImageExpectation& expectation,
                                                     PngDepth depth);

/// Decodes a PNG file of any colour type to 8-bit RGB. Drops alpha.
absl::StatusOr<Image<Rgb>> DecodePngColor(std::string_view data,
                                          const ImageExpectation& expectation);

}  // namespace steadymap
