#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include <absl/status/statusor.h>

#include "core/frame/frame.h"

/// Decoders and encoders for the images of a frame. Every decoder treats its input as hostile. The
/// declared size is compared with the caller's expected size before any allocation. Compressed data
/// may expand at most `kMaxCompressionRatio` times. Malformed data cause a status, never an
/// exception, a crash or an allocation of a size chosen by the input.
///
/// All functions are pure. Any thread.
namespace steadymap {

/// Encoding of the pixels of a depth, label or instance image.
enum class PixelEncoding {
  kRawUint8,    ///< One byte per pixel, row-major.
  kRawUint16,   ///< Two bytes per pixel, little-endian, row-major.
  kPng,         ///< A PNG file: greyscale or palette indices, 8 or 16 bits, not interlaced.
  kZstdUint8,   ///< A zstd frame with the data of kRawUint8.
  kZstdUint16,  ///< A zstd frame with the data of kRawUint16.
};

/// Encoding of the pixels of a colour image.
enum class ColorEncoding {
  kJpeg,     ///< A baseline or progressive JPEG file, RGB or greyscale.
  kPng,      ///< A PNG file: RGB, RGBA (alpha dropped), greyscale or palette, 8 or 16 bits.
  kRawRgb8,  ///< Three bytes per pixel, row-major.
};

/// Maximum size ratio of decoded to compressed image, for decoded images larger than
/// `kSmallImageBytes`.
inline constexpr std::size_t kMaxCompressionRatio = 200;

/// Images of at most this decoded size are exempt from the ratio: the compression ratio of a label
/// image of a single class is about 1000, and a small image takes little time and memory.
inline constexpr std::size_t kSmallImageBytes = std::size_t{1} << 20;

/// Decodes a single-channel image of `width_px` x `height_px` pixels. 8-bit pixels are widened. A
/// palette PNG gives its palette indices, the usual form of a label image. Errors:
/// `InvalidArgument` with reason `IMAGE_SIZE_MISMATCH` or `BAD_IMAGE_ENCODING`.
absl::StatusOr<Image<std::uint16_t>> DecodePixels(std::string_view data,
                                                  PixelEncoding encoding,
                                                  int width_px,
                                                  int height_px);

/// Decodes a depth image of `width_px` x `height_px` pixels with 16 bits per pixel. Errors:
/// `InvalidArgument` with reason `IMAGE_SIZE_MISMATCH` or `BAD_DEPTH_ENCODING`.
absl::StatusOr<Image<std::uint16_t>> DecodeDepth(std::string_view data,
                                                 PixelEncoding encoding,
                                                 int width_px,
                                                 int height_px);

/// Decodes a colour image of `width_px` x `height_px` pixels. Errors: `InvalidArgument` with reason
/// `IMAGE_SIZE_MISMATCH` or `BAD_IMAGE_ENCODING`.
absl::StatusOr<Image<Rgb>> DecodeColor(std::string_view data,
                                       ColorEncoding encoding,
                                       int width_px,
                                       int height_px);

/// Encodes a single-channel image. The 8-bit encodings require pixels below 256 (asserted). `kPng`
/// writes 8 bits per pixel if all pixels fit and `force_16_bits` is false, else 16.
std::string EncodePixels(const Image<std::uint16_t>& image,
                         PixelEncoding encoding,
                         bool force_16_bits = false);

/// Encodes a colour image as PNG (lossless).
std::string EncodeColorPng(const Image<Rgb>& image);

/// The size of an image, pixels.
struct ImageSize {
  int width_px = 0;
  int height_px = 0;
};

/// Returns the declared size from the header of a PNG or JPEG file. Errors: `InvalidArgument` with
/// reason `BAD_IMAGE_ENCODING` if `data` is neither or its header is malformed.
absl::StatusOr<ImageSize> PeekImageSize(std::string_view data);

}  // namespace steadymap
