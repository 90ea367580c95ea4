#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include <absl/status/statusor.h>

#include "core/frame/frame.h"

/// Decoding and encoding of the images that a frame carries. Every decoder treats its input as
/// hostile: the size that the caller expects is compared with what the data declare before anything
/// is allocated, compressed data may expand at most `kMaxCompressionRatio` times, and malformed
/// data end in a status, never in an exception, a crash or an allocation that the input chose.
///
/// All functions are pure and may be called from any thread.
namespace steadymap {

/// How the pixels of a depth, label or instance image are packed.
enum class PixelEncoding {
  kRawUint8,    ///< One byte a pixel, row-major.
  kRawUint16,   ///< Two bytes a pixel, little-endian, row-major.
  kPng,         ///< A PNG file: greyscale or palette indices, 8 or 16 bits, not interlaced.
  kZstdUint8,   ///< A zstd frame of kRawUint8.
  kZstdUint16,  ///< A zstd frame of kRawUint16.
};

/// How the pixels of a colour image are packed.
enum class ColorEncoding {
  kJpeg,     ///< A baseline or progressive JPEG file, RGB or greyscale.
  kPng,      ///< A PNG file: RGB, RGBA (alpha dropped), greyscale or palette, 8 or 16 bits.
  kRawRgb8,  ///< Three bytes a pixel, row-major.
};

/// Most bytes that one byte of compressed image may expand to, once the image is larger than
/// `kSmallImageBytes`.
inline constexpr std::size_t kMaxCompressionRatio = 200;

/// Images that decode to no more than this are exempt from the ratio: a label image of one class
/// compresses a thousandfold, and a small one costs nothing.
inline constexpr std::size_t kSmallImageBytes = std::size_t{1} << 20;

/// Decodes a single-channel image that must measure `width_px` x `height_px`; 8-bit pixels widen.
/// Palette PNGs yield palette indices, as label images use them.
/// Errors: `InvalidArgument` with reason `IMAGE_SIZE_MISMATCH` or `BAD_IMAGE_ENCODING`.
absl::StatusOr<Image<std::uint16_t>> DecodePixels(std::string_view data,
                                                  PixelEncoding encoding,
                                                  int width_px,
                                                  int height_px);

/// Decodes a depth image, which must have 16 bits a pixel.
/// Errors: `InvalidArgument` with reason `IMAGE_SIZE_MISMATCH` or `BAD_DEPTH_ENCODING`.
absl::StatusOr<Image<std::uint16_t>> DecodeDepth(std::string_view data,
                                                 PixelEncoding encoding,
                                                 int width_px,
                                                 int height_px);

/// Decodes a colour image that must measure `width_px` x `height_px`.
/// Errors: `InvalidArgument` with reason `IMAGE_SIZE_MISMATCH` or `BAD_IMAGE_ENCODING`.
absl::StatusOr<Image<Rgb>> DecodeColor(std::string_view data,
                                       ColorEncoding encoding,
                                       int width_px,
                                       int height_px);

/// Encodes a single-channel image. For the 8-bit encodings every pixel must be below 256
/// (asserted); `kPng` writes 8 bits where all pixels fit and `force_16_bits` is not set, else 16
/// bits.
std::string EncodePixels(const Image<std::uint16_t>& image,
                         PixelEncoding encoding,
                         bool force_16_bits = false);

/// Encodes a colour image as PNG (lossless).
std::string EncodeColorPng(const Image<Rgb>& image);

/// Width and height that a PNG or JPEG file declares, read from its header alone.
/// Errors: `InvalidArgument` with reason `BAD_IMAGE_ENCODING` if it is neither.
struct ImageSize {
  int width_px = 0;
  int height_px = 0;
};

absl::StatusOr<ImageSize> PeekImageSize(std::string_view data);

}  // namespace steadymap
