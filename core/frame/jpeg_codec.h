#pragma once

#include <string_view>

#include <absl/status/statusor.h>

#include "core/frame/frame.h"
#include "core/frame/image_expectation.h"

/// Private to the image codecs: JPEG by libjpeg-turbo, with hostile files in mind.
///
/// What libjpeg would paper over (a cut file, corrupt data) is refused, as are arithmetic coding,
/// more than a fixed number of scans, colour spaces but RGB, YCbCr and grey, and bytes after the
/// image.
namespace steadymap {

/// Whether `data` starts as every JPEG file does.
bool LooksLikeJpeg(std::string_view data);

/// Width and height from the header of a JPEG file; neither is 0.
absl::Status ReadJpegSize(std::string_view data,
                          const ImageExpectation& expectation,
                          int* width_px,
                          int* height_px);

/// Decodes a file to 8-bit RGB.
absl::StatusOr<Image<Rgb>> DecodeJpegColor(std::string_view data,
                                           const ImageExpectation& expectation);

}  // namespace steadymap
