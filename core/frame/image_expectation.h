#pragma once

#include <cstddef>
#include <string_view>

#include <absl/status/status.h>

/// Private to the image codecs: checks before a decoder allocates memory.
namespace steadymap {

/// The expected properties of an image to be decoded.
struct ImageExpectation {
  int width_px = 0;
  int height_px = 0;
  std::string_view malformed_reason;  ///< Reason of all errors except a wrong size.
};

/// Returns an error on the field `data` for an undecodable image, with the reason of the
/// expectation.
absl::Status MalformedImage(const ImageExpectation& expectation, std::string_view message);

/// Returns an error on the field `encoding` for a packing that is invalid for this image, with the
/// reason of the expectation.
absl::Status UnsupportedPacking(const ImageExpectation& expectation, std::string_view message);

/// Returns `IMAGE_SIZE_MISMATCH` unless both sides of the expected size are in [1,
/// kMaxImageSidePx].
absl::Status CheckExpectedSize(const ImageExpectation& expectation);

/// Returns `IMAGE_SIZE_MISMATCH` unless `width_px` x `height_px`, the size declared by the data,
/// equals the expected size.
absl::Status CheckDeclaredSize(const ImageExpectation& expectation, int width_px, int height_px);

/// Returns `IMAGE_SIZE_MISMATCH` unless `found_bytes`, the length of the unpacked pixels, equals
/// the length of an image of the expected size with `bytes_per_pixel`.
absl::Status CheckPixelBytes(const ImageExpectation& expectation,
                             std::size_t bytes_per_pixel,
                             unsigned long long found_bytes);

/// Returns an error if an image of the expected size with `bytes_per_pixel` is larger than
/// `kSmallImageBytes` and expands from `packed_bytes` by more than `kMaxCompressionRatio`.
absl::Status CheckCompressionRatio(const ImageExpectation& expectation,
                                   std::size_t bytes_per_pixel,
                                   std::size_t packed_bytes);

/// Returns the length of the pixels of an image of the expected size, bytes.
std::size_t ExpectedBytes(const ImageExpectation& expectation, std::size_t bytes_per_pixel);

}  // namespace steadymap
