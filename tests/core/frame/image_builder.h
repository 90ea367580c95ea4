#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "core/frame/frame.h"

/// Images and image files for the tests of the codecs. The files are assembled byte by byte, so
/// they can contain errors that no encoder writes.
namespace steadymap {

/// Returns uniformly random pixels in [0, `highest`].
Image<std::uint16_t> RandomPixels(int width_px, int height_px, int highest, std::mt19937* random);

/// Returns uniformly random colours.
Image<Rgb> RandomColors(int width_px, int height_px, std::mt19937* random);

/// Colour types, numbered as in the PNG specification.
inline constexpr int kPngGrey = 0;
inline constexpr int kPngRgb = 2;
inline constexpr int kPngPalette = 3;
inline constexpr int kPngGreyAlpha = 4;
inline constexpr int kPngRgbAlpha = 6;

/// The pixel format in the header of a PNG file.
struct PngKind {
  int color_type = kPngGrey;
  int bit_depth = 8;
  bool interlaced = false;
};

/// Returns a PNG file in which every pixel has the bytes `pixel`. A palette file has four colours
/// (100 + i, 150 + i, 200 + i). `extra_chunks` follow the header and precede the pixels.
std::string MakePng(int width_px,
                    int height_px,
                    const PngKind& kind,
                    const std::vector<std::uint8_t>& pixel,
                    std::string_view extra_chunks = {});

/// Returns one PNG chunk with its length and checksum.
std::string MakePngChunk(std::string_view name, std::string_view content);

/// The image that MakeJpeg writes: one uniform colour, quality 95, no chroma subsampling.
struct JpegKind {
  int width_px = 8;
  int height_px = 8;
  int channels = 3;  ///< 1 (grey), 3 (YCbCr) or 4 (CMYK).
  Rgb color = {0, 0, 0};
  bool progressive = false;
};

/// Returns a JPEG file.
std::string MakeJpeg(const JpegKind& kind);

/// Returns a zstd frame of `content`, which declares its content size if `declares_size`.
std::string MakeZstd(std::string_view content, bool declares_size = true);

}  // namespace steadymap
