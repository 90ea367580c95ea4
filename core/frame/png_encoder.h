#pragma once

#include <cstdint>
#include <string>

#include "core/frame/frame.h"

namespace steadymap {

/// Encodes a greyscale image with 16 bits per pixel, or with 8 (every pixel below 256, asserted).
/// An empty image gives an empty string.
std::string EncodePngPixels(const Image<std::uint16_t>& image, bool with_16_bits);

/// Encodes an RGB image with 8 bits per channel. An empty image gives an empty string.
std::string EncodePngColor(const Image<Rgb>& image);

}  // namespace steadymap
