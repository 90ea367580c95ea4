#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <absl/status/status.h>

#include "core/geometry/geometry.h"
#include "core/types/identifiers.h"
#include "core/types/map_config.h"
#include "core/types/timestamp.h"

namespace steadymap {

/// A dense image, row-major from the top left pixel, without padding. Empty when a side is 0.
template <typename Pixel>
class Image {
 public:
  Image() = default;

  Image(int width_px, int height_px, Pixel value = {})
      : width_px_(width_px),
        height_px_(height_px),
        pixels_(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px), value) {}

  int width_px() const { return width_px_; }

  int height_px() const { return height_px_; }

  bool empty() const { return pixels_.empty(); }

  std::size_t size() const { return pixels_.size(); }

  /// The first pixel; the others follow row by row.
  Pixel* data() { return pixels_.data(); }

  const Pixel* data() const { return pixels_.data(); }

  Pixel& At(int u, int v) { return pixels_[Index(u, v)]; }

  const Pixel& At(int u, int v) const { return pixels_[Index(u, v)]; }

  friend bool operator==(const Image&, const Image&) = default;

 private:
  std::size_t Index(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width_px_) +
           static_cast<std::size_t>(u);
  }

  int width_px_ = 0;
  int height_px_ = 0;
  std::vector<Pixel> pixels_;
};

/// Red, green, blue, 8 bits each, sRGB.
using Rgb = std::array<std::uint8_t, 3>;

/// Depth along the camera's z axis in sensor units; 0 and 65535 mean no return.
struct DepthImage {
  Image<std::uint16_t> units;
  double metres_per_unit = 0.001;  ///< In [1e-6, 1e-1].

  friend bool operator==(const DepthImage&, const DepthImage&) = default;
};

/// Depth values that mean "no return".
inline constexpr std::uint16_t kNoDepth = 0;
inline constexpr std::uint16_t kInvalidDepth = 65535;

/// What one robot saw at one moment: the only input of a map.
struct Frame {
  SensorName source;       ///< What took it.
  Timestamp capture_time;  ///< When it was taken, by the robot's clock.
  PinholeCamera camera;    ///< Intrinsics of every image of the frame.
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
  DepthImage depth;                ///< Never empty in a valid frame.
  Image<std::uint16_t> labels;     ///< Class of each pixel; empty: all class 0.
  Image<std::uint16_t> instances;  ///< Instance of each pixel, 0 none; empty: unknown.
  Image<Rgb> color;                ///< Aligned with depth; empty: not recorded.
};

/// OK if a frame can be integrated into a map whose label images may hold `labels`: usable camera,
/// every image that is present as large as the camera says, no other label, depth unit in range,
/// finite pose within `kMaxPositionM`.
/// Errors: `InvalidArgument` with the reason and field path of the service contract.
absl::Status ValidateFrame(const Frame& frame, const KnownLabels& labels);

}  // namespace steadymap
