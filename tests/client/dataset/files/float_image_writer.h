#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/frame/frame.h"

namespace steadymap {

/// How an OpenEXR file is laid out.
struct ExrLayout {
  std::vector<std::string> channels = {"V"};  ///< The first that is read holds the image.
  bool is_half = false;
  bool is_tiled = false;
};

/// Writes an image as an OpenEXR file; channels but the one that must be read hold -1.
void WriteExr(const std::filesystem::path& file,
              const Image<float>& image,
              const std::string& channel = "V",
              const ExrLayout& layout = {});

/// Writes an image as a TIFF file of floats, deflated on request.
void WriteTiff(const std::filesystem::path& file,
               const Image<float>& image,
               bool is_compressed = false);

}  // namespace steadymap
