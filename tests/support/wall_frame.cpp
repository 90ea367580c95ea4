#include "tests/support/wall_frame.h"

#include <cmath>

#include "core/frame/image_codec.h"
#include "proto/convert_frame.h"
#include "proto/convert_geometry.h"

namespace steadymap {
namespace {

constexpr double kMetresPerUnit = 0.001;
constexpr std::uint16_t kWallClass = 4;

/// Returns a pose with the camera's z axis along world x, its x axis along -y, and its y axis down.
Eigen::Isometry3d LookAlongX(const Eigen::Vector3d& eye_world) {
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
  T_world_camera.translation() = eye_world;
  T_world_camera.linear().col(0) = -Eigen::Vector3d::UnitY();
  T_world_camera.linear().col(1) = -Eigen::Vector3d::UnitZ();
  T_world_camera.linear().col(2) = Eigen::Vector3d::UnitX();
  return T_world_camera;
}

PixelEncoding PixelsOf(v1::DepthEncoding encoding) {
  if (encoding == v1::DEPTH_ENCODING_PNG_UINT16) return PixelEncoding::kPng;
  if (encoding == v1::DEPTH_ENCODING_ZSTD_UINT16) return PixelEncoding::kZstdUint16;
  return PixelEncoding::kRawUint16;
}

}  // namespace

v1::Frame MakeWallFrame(const WallFrame& wall) {
  const PinholeCamera camera{wall.width_px,
                             wall.height_px,
                             1.0 * wall.width_px,
                             1.0 * wall.width_px,
                             (wall.width_px - 1) / 2.0,
                             (wall.height_px - 1) / 2.0};
  const auto units = static_cast<std::uint16_t>(std::lround(wall.wall_distance_m / kMetresPerUnit));
  const Image<std::uint16_t> depth(wall.width_px, wall.height_px, units);
  const Image<std::uint16_t> labels(wall.width_px, wall.height_px, kWallClass);

  v1::Frame frame;
  *frame.mutable_capture_time() = ToProto(Timestamp::FromSeconds(wall.capture_time_s));
  *frame.mutable_intrinsics() = ToProto(camera);
  *frame.mutable_world_from_camera() = ToProto(LookAlongX(wall.eye_world));
  frame.mutable_depth()->set_encoding(wall.encoding);
  frame.mutable_depth()->set_metres_per_unit(kMetresPerUnit);
  frame.mutable_depth()->set_data(EncodePixels(depth, PixelsOf(wall.encoding), true));
  if (wall.with_labels) {
    frame.mutable_labels()->set_encoding(v1::LABEL_ENCODING_RAW_UINT8);
    frame.mutable_labels()->set_data(EncodePixels(labels, PixelEncoding::kRawUint8));
  }
  return frame;
}

}  // namespace steadymap
