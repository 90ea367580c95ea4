#pragma once

#include <cstddef>
#include <string_view>

#include <absl/status/status.h>

/// Private to the image codecs: the checks that come before a decoder may allocate.
namespace steadymap {

/// What the caller of a decoder expects of the image that it hands over.
struct ImageExpectation {
  int width_px = 0;
  int height_px = 0;
  std::string_view malformed_reason;  ///< Reason of every error but a wrong size.
};

/// The image cannot be decoded: an error with the expectation's reason, on the field `data`.
absl::Status MalformedImage(const ImageExpectation& expectation, std::string_view message);

/// The packing is none that this image may have: as MalformedImage, on the field `encoding`.
absl::Status UnsupportedPacking(const ImageExpectation& expectation, std::string_view message);

/// `IMAGE_SIZE_MISMATCH` unless the expected size lies in [1, kMaxImageSidePx] on both sides.
absl::Status CheckExpectedSize(const ImageExpectation& expectation);

/// `IMAGE_SIZE_MISMATCH` unless `width_px` x `height_px`, as the data declare, is what is expected.
absl::Status CheckDeclaredSize(const ImageExpectation& expectation, int width_px, int height_px);

/// `IMAGE_SIZE_MISMATCH` unless `found_bytes`, the length of the unpacked pixels, is what an image
/// of the expected size takes at `bytes_per_pixel`.
absl::Status CheckPixelBytes(const ImageExpectation& expectation,
                             std::size_t bytes_per_pixel,
                             unsigned long long found_bytes);

/// An error if `packed_bytes` would expand beyond `kMaxCompressionRatio` in an image of the
/// expected size at `bytes_per_pixel` that is no small one.
absl::Status CheckCompressionRatio(const ImageExpectation& expectation,
                                   std::size_t bytes_per_pixel,
                                   std::size_t packed_bytes);

/// Bytes of the expected image's pixels.
std::size_t ExpectedBytes(const ImageExpectation& expectation, std::size_t bytes_per_pixel);

}  // namespace steadymap
