#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/frame/frame.h"

namespace steadymap {

/// Layout of an OpenEXR file.
struct ExrLayout {
  std::vector<std::string> channels = {"V"};  ///< The first readable channel holds the image.
  bool is_half = false;
  bool is_tiled = false;
};

/// Writes an image as an OpenEXR file; all channels except `channel` contain -1.
void WriteExr(const std::filesystem::path& file,
              const Image<float>& image,
              const std::string& channel = "V",
              const ExrLayout& layout = {});

/// Writes an image as a TIFF file of floats, optionally deflated.
void WriteTiff(const std::filesystem::path& file,
               const Image<float>& image,
               bool is_compressed = false);

}  // namespace steadymap
