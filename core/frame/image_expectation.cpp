#include "core/frame/image_expectation.h"

#include <absl/strings/str_cat.h>

#include "core/frame/image_codec.h"
#include "core/geometry/geometry.h"
#include "core/types/error.h"

namespace steadymap {

absl::Status MalformedImage(const ImageExpectation& expectation, std::string_view message) {
  return InvalidField(expectation.malformed_reason, "data", message);
}

absl::Status UnsupportedPacking(const ImageExpectation& expectation, std::string_view message) {
  return InvalidField(expectation.malformed_reason, "encoding", message);
}

absl::Status CheckExpectedSize(const ImageExpectation& expectation) {
  for (const int side_px : {expectation.width_px, expectation.height_px}) {
    if (side_px >= 1 && side_px <= kMaxImageSidePx) continue;
    return InvalidField(
        reason::kImageSizeMismatch,
        "data",
        absl::StrCat("image sides must lie in [1, ", kMaxImageSidePx, "] pixels, got ", side_px));
  }
  return absl::OkStatus();
}

absl::Status CheckDeclaredSize(const ImageExpectation& expectation, int width_px, int height_px) {
  if (width_px == expectation.width_px && height_px == expectation.height_px) {
    return absl::OkStatus();
  }
  return InvalidField(reason::kImageSizeMismatch,
                      "data",
                      absl::StrCat("the image must measure ",
                                   expectation.width_px,
                                   " x ",
                                   expectation.height_px,
                                   " pixels, got ",
                                   width_px,
                                   " x ",
                                   height_px));
}

absl::Status CheckPixelBytes(const ImageExpectation& expectation,
                             std::size_t bytes_per_pixel,
                             unsigned long long found_bytes) {
  const std::size_t expected_bytes = ExpectedBytes(expectation, bytes_per_pixel);
  if (found_bytes == expected_bytes) return absl::OkStatus();
  return InvalidField(reason::kImageSizeMismatch,
                      "data",
                      absl::StrCat("an image of ",
                                   expectation.width_px,
                                   " x ",
                                   expectation.height_px,
                                   " pixels takes ",
                                   expected_bytes,
                                   " bytes, got ",
                                   found_bytes));
}

absl::Status CheckCompressionRatio(const ImageExpectation& expectation,
                                   std::size_t bytes_per_pixel,
                                   std::size_t packed_bytes) {
  const std::size_t unpacked_bytes = ExpectedBytes(expectation, bytes_per_pixel);
  if (unpacked_bytes <= kSmallImageBytes) return absl::OkStatus();
  if (unpacked_bytes / kMaxCompressionRatio <= packed_bytes) return absl::OkStatus();
  return MalformedImage(expectation,
                        absl::StrCat("the ratio of decoded to compressed size must be at most ",
                                     kMaxCompressionRatio,
                                     ", got ",
                                     packed_bytes,
                                     " compressed bytes for ",
                                     unpacked_bytes));
}

std::size_t ExpectedBytes(const ImageExpectation& expectation, std::size_t bytes_per_pixel) {
  return static_cast<std::size_t>(expectation.width_px) *
         static_cast<std::size_t>(expectation.height_px) * bytes_per_pixel;
}

}  // namespace steadymap
