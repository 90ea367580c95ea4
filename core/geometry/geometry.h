#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <absl/status/status.h>
#include <absl/status/statusor.h>

/// The coordinate frames of the project:
///
/// - `world`:  the frame of the map. Right-handed, z up, metres.
/// - `robot`:  x forward, y left, z up. Used only by data set loaders and the simulator.
/// - `camera`: the optical frame. x right, y down, z forward, metres.
/// - `object`: the frame of an object's volume: `world`, translated and rotated by a yaw, metres.
/// - `grid`:   voxel indices of a volume; `core/volume/voxel_leaf.h` defines the convention.
///
/// A rigid transform is named `T_destination_source`: `p_world = T_world_camera * p_camera`.
namespace steadymap {

/// An axis-aligned box in the frame given by the variable's name, metres. Empty if any `min > max`.
using Box = Eigen::AlignedBox3d;

/// Returns a box enlarged by `margin_m` on all sides; an empty one stays empty.
inline Box Grow(const Box& box, double margin_m) {
  if (box.isEmpty()) return box;
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(margin_m);
  return {box.min() - margin, box.max() + margin};
}

/// A pinhole camera without distortion.
///
/// A point `(x, y, z)` of the camera frame projects to the pixel
/// `(fx * x / z + cx, fy * y / z + cy)`. Integer pixel coordinates are pixel centres.
struct PinholeCamera {
  int width_px = 0;   ///< Image width, in [1, 4096].
  int height_px = 0;  ///< Image height, in [1, 4096].
  double fx = 0.0;    ///< Focal length along x, pixels. Range: `ValidateCamera`.
  double fy = 0.0;    ///< Focal length along y, pixels. Range: `ValidateCamera`.
  double cx = 0.0;    ///< Principal point along x, pixels. Range: `ValidateCamera`.
  double cy = 0.0;    ///< Principal point along y, pixels. Range: `ValidateCamera`.

  /// Returns the ray (z = 1) through pixel (`u`, `v`), camera frame.
  Eigen::Vector3d Ray(double u, double v) const { return {(u - cx) / fx, (v - cy) / fy, 1.0}; }

  /// Projects a point of the camera frame with z > 0 to pixel coordinates. The point falls on pixel
  /// `(u, v)` if the result, plus 0.5, rounds down to it.
  template <typename Scalar>
  Eigen::Matrix<Scalar, 2, 1> Project(const Eigen::Matrix<Scalar, 3, 1>& point_camera) const {
    return {
        static_cast<Scalar>(fx) * point_camera.x() / point_camera.z() + static_cast<Scalar>(cx),
        static_cast<Scalar>(fy) * point_camera.y() / point_camera.z() + static_cast<Scalar>(cy)};
  }

  /// True if pixel coordinates fall on a pixel of the image.
  template <typename Scalar>
  bool Contains(const Eigen::Matrix<Scalar, 2, 1>& pixel) const {
    constexpr auto kHalf = static_cast<Scalar>(0.5);
    return pixel.x() >= -kHalf && pixel.x() < static_cast<Scalar>(width_px) - kHalf &&
           pixel.y() >= -kHalf && pixel.y() < static_cast<Scalar>(height_px) - kHalf;
  }

  friend bool operator==(const PinholeCamera&, const PinholeCamera&) = default;
};

/// Largest valid image side, pixels.
inline constexpr int kMaxImageSidePx = 4096;

/// Largest valid distance of a pose from the map's origin. Beyond it, a voxel index could exceed
/// the range of keys and codecs.
inline constexpr double kMaxPositionM = 10'000.0;

/// Returns OK if the camera is valid. Errors: `InvalidArgument` with reason `BAD_INTRINSICS` unless
/// image sides are in [1, `kMaxImageSidePx`], focal lengths are in [1/20 of the image side, 1e5]
/// pixels, and the principal point lies within one image size of the image.
absl::Status ValidateCamera(const PinholeCamera& camera);

/// Returns OK if a position is finite and within `kMaxPositionM` of the origin. Errors:
/// `InvalidArgument` with reason `NON_FINITE_POSE` and `field`.
absl::Status CheckPosition(const char* field, const Eigen::Vector3d& position_m);

/// Makes a rigid transform from a position [m] and a quaternion (x, y, z, w).
///
/// Normalises a quaternion whose norm is within 1e-3 of one. Errors: `InvalidArgument` with reason
/// `NON_FINITE_POSE` for NaN, infinity, or a position further than `kMaxPositionM` from the origin;
/// with reason `NOT_A_ROTATION` for any other quaternion.
absl::StatusOr<Eigen::Isometry3d> MakePose(const Eigen::Vector3d& position_m,
                                           const Eigen::Vector4d& quaternion_xyzw);

/// Returns the transform with a translation and a rotation vector (axis times angle, radians).
Eigen::Isometry3d TransformOf(const Eigen::Vector3d& translation,
                              const Eigen::Vector3d& rotation_vector);

/// Returns the heading of the transform's x axis in the xy plane of the destination, radians in
/// (-pi, pi].
double YawOf(const Eigen::Isometry3d& transform);

}  // namespace steadymap
