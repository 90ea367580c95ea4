#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <absl/status/status.h>

#include "core/frame/depth_sensor.h"
#include "core/geometry/geometry.h"
#include "core/types/identifiers.h"
#include "core/types/map_config.h"
#include "core/types/timestamp.h"

namespace steadymap {

/// A dense image, row-major from the top left pixel, without padding. Empty if a side is 0.
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

  /// Returns the first pixel; the other pixels follow row by row.
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

/// An sRGB colour: red, green, blue, 8 bits each.
using Rgb = std::array<std::uint8_t, 3>;

/// Depth along the camera's z axis in sensor units. `kNoDepth` and `kInvalidDepth` mean no return.
struct DepthImage {
  Image<std::uint16_t> units;
  double metres_per_unit = 0.001;  ///< In [1e-6, 1e-1].
  DepthSensorKind sensor = DepthSensorKind::kUnknown;

  friend bool operator==(const DepthImage&, const DepthImage&) = default;
};

/// The two depth values of pixels without return.
inline constexpr std::uint16_t kNoDepth = 0;
inline constexpr std::uint16_t kInvalidDepth = 65535;

/// The data of one sensor at one time: the input of a map.
struct Frame {
  SensorName source;       ///< The sensor that recorded the frame.
  Timestamp capture_time;  ///< Time of exposure by the robot's clock.
  PinholeCamera camera;    ///< Intrinsics of all images of the frame.
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
  DepthImage depth;                ///< Never empty in a valid frame.
  Image<std::uint16_t> labels;     ///< Class of each pixel. Empty: class 0 everywhere.
  Image<std::uint16_t> instances;  ///< Instance of each pixel, 0 for none. Empty: unknown.
  Image<Rgb> color;                ///< Aligned with depth. Empty: not recorded.
};

/// Returns OK if a frame can be integrated into a map with the known labels `labels`: the camera is
/// valid, every non-empty image has the size of the camera, `depth` is not empty, no other label
/// occurs, the depth unit is in range, and the pose is finite, within `kMaxPositionM` and a
/// rotation. Errors: `InvalidArgument` with reason and field path.
absl::Status ValidateFrame(const Frame& frame, const KnownLabels& labels);

}  // namespace steadymap
