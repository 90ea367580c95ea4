#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include <absl/status/statusor.h>

#include "core/frame/frame.h"
#include "core/frame/image_expectation.h"

/// Private to the image codecs: PNG by libpng, with hostile files in mind.
///
/// Interlaced files are refused, as are checksum errors in any chunk, chunks beyond a fixed size,
/// and anything before, after or beyond the image. Metadata (text, profiles, gamma) is skipped
/// unread.
namespace steadymap {

/// Whether `data` starts as every PNG file does.
bool LooksLikePng(std::string_view data);

/// Width and height from the header of a PNG file; neither is 0.
absl::Status ReadPngSize(std::string_view data,
                         const ImageExpectation& expectation,
                         int* width_px,
                         int* height_px);

/// Bits a pixel that a single-channel PNG file may have.
enum class PngDepth { k8Or16Bits, k16BitsOnly };

/// Decodes a greyscale file or the indices of a palette file.
absl::StatusOr<Image<std::uint16_t>> DecodePngPixels(std::string_view data,
                                                     const ImageExpectation& expectation,
                                                     PngDepth depth);

/// Decodes a file of any colour type to 8-bit RGB; alpha is dropped.
absl::StatusOr<Image<Rgb>> DecodePngColor(std::string_view data,
                                          const ImageExpectation& expectation);

}  // namespace steadymap
