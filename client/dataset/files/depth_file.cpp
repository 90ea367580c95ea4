#include "client/dataset/files/depth_file.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include <absl/strings/ascii.h>

#include "client/dataset/files/exr_file.h"
#include "client/dataset/files/image_file.h"
#include "client/dataset/files/tiff_file.h"
#include "core/frame/frame.h"
#include "core/frame/image_codec.h"

namespace steadymap {
namespace {

std::uint16_t UnitsOf(float depth_m, double metres_per_unit) {
  const double units = std::round(static_cast<double>(depth_m) / metres_per_unit);
  // NaN fails both comparisons.
  if (!(units > kNoDepth && units < kInvalidDepth)) return kNoDepth;
  return static_cast<std::uint16_t>(units);
}

}  // namespace

absl::Status PackDepthFile(const std::filesystem::path& file,
                           const PinholeCamera& camera,
                           double metres_per_unit,
                           v1::DepthImage* message) {
  message->set_metres_per_unit(metres_per_unit);
  const std::string ending = absl::AsciiStrToLower(file.extension().string());
  const bool is_exr = ending == ".exr";
  if (!is_exr && ending != ".tif" && ending != ".tiff") {
    absl::StatusOr<ImageFile> image = ReadPngFile(file, camera);
    if (!image.ok()) return image.status();
    message->set_encoding(v1::DEPTH_ENCODING_PNG_UINT16);
    message->set_data(std::move(image->data));
    return absl::OkStatus();
  }
  const absl::StatusOr<Image<float>> depth_m =
      is_exr ? ReadExrFile(file, camera) : ReadTiffFile(file, camera);
  if (!depth_m.ok()) return depth_m.status();
  Image<std::uint16_t> units(depth_m->width_px(), depth_m->height_px());
  std::transform(depth_m->data(),
                 depth_m->data() + depth_m->size(),
                 units.data(),
                 [metres_per_unit](float depth) { return UnitsOf(depth, metres_per_unit); });
  message->set_encoding(v1::DEPTH_ENCODING_ZSTD_UINT16);
  message->set_data(EncodePixels(units, PixelEncoding::kZstdUint16));
  return absl::OkStatus();
}

}  // namespace steadymap
