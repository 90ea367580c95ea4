#pragma once

#include <cstdint>
#include <string>

#include "core/frame/frame.h"

namespace steadymap {

/// Encodes a greyscale image with 8 bits a pixel (every pixel below 256) or 16.
std::string EncodePngPixels(const Image<std::uint16_t>& image, bool with_16_bits);

/// Encodes an RGB image with 8 bits a channel.
std::string EncodePngColor(const Image<Rgb>& image);

}  // namespace steadymap
