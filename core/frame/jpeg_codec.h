#pragma once

#include <string_view>

#include <absl/status/statusor.h>

#include "core/frame/frame.h"
#include "core/frame/image_expectation.h"

/// Private to the image codecs: JPEG by libjpeg-turbo, hardened against hostile files.
///
/// Rejects files that libjpeg would repair silently (truncated or corrupt data), arithmetic coding,
/// more than a fixed number of scans, colour spaces other than RGB, YCbCr and grey, and bytes after
/// the image.
namespace steadymap {

/// True if `data` starts with the JPEG signature.
bool HasJpegSignature(std::string_view data);

/// Reads width and height from the header of a JPEG file; neither is 0.
absl::Status ReadJpegSize(std::string_view data,
                          const ImageExpectation& expectation,
                          int* width_px,
                          int* height_px);

/// Decodes a JPEG file to 8-bit RGB.
absl::StatusOr<Image<Rgb>> DecodeJpegColor(std::string_view data,
                                           const ImageExpectation& expectation);

}  // namespace steadymap
