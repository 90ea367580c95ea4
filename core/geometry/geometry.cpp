#include "core/geometry/geometry.h"

#include <cmath>

#include <absl/strings/str_cat.h>

#include "core/types/error.h"

namespace steadymap {
namespace {

constexpr double kMaxFocalLengthPx = 1e5;

// The maximum image side in focal lengths: a field of view of 169 degrees, wider than that of any
// pinhole camera.
constexpr double kMaxSideFocalLengths = 20.0;

// Clients often round quaternions to six digits. A larger error is a defect of the client.
constexpr double kQuaternionNormTolerance = 1e-3;

absl::Status CheckImageSide(const char* field, int side_px) {
  if (side_px >= 1 && side_px <= kMaxImageSidePx) return absl::OkStatus();
  return InvalidField(
      reason::kBadIntrinsics,
      field,
      absl::StrCat(field, " must lie in [1, ", kMaxImageSidePx, "] pixels, got ", side_px));
}

absl::Status CheckFocalLength(const char* field, double focal_length_px, int side_px) {
  const double least_px = side_px / kMaxSideFocalLengths;
  if (focal_length_px >= least_px && focal_length_px <= kMaxFocalLengthPx) return absl::OkStatus();
  return InvalidField(reason::kBadIntrinsics,
                      field,
                      absl::StrCat(field,
                                   " must lie in [",
                                   least_px,
                                   ", ",
                                   kMaxFocalLengthPx,
                                   "] pixels, got ",
                                   focal_length_px));
}

absl::Status CheckPrincipalPoint(const char* field, double coordinate_px, int side_px) {
  if (coordinate_px >= -side_px && coordinate_px <= 2.0 * side_px) return absl::OkStatus();
  return InvalidField(reason::kBadIntrinsics,
                      field,
                      absl::StrCat(field,
                                   " must lie within one image size of the image, in [",
                                   -side_px,
                                   ", ",
                                   2 * side_px,
                                   "] pixels, got ",
                                   coordinate_px));
}

}  // namespace

absl::Status ValidateCamera(const PinholeCamera& camera) {
  // NaN fails every comparison, so each check also rejects NaN.
  for (const absl::Status& status : {CheckImageSide("width_px", camera.width_px),
                                     CheckImageSide("height_px", camera.height_px),
                                     CheckFocalLength("fx", camera.fx, camera.width_px),
                                     CheckFocalLength("fy", camera.fy, camera.height_px),
                                     CheckPrincipalPoint("cx", camera.cx, camera.width_px),
                                     CheckPrincipalPoint("cy", camera.cy, camera.height_px)}) {
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status CheckPosition(const char* field, const Eigen::Vector3d& position_m) {
  if (position_m.allFinite() && position_m.norm() <= kMaxPositionM) return absl::OkStatus();
  return InvalidField(reason::kNonFinitePose,
                      field,
                      absl::StrCat("the position must be finite and within ",
                                   kMaxPositionM,
                                   " m of the map's origin, got (",
                                   position_m.x(),
                                   ", ",
                                   position_m.y(),
                                   ", ",
                                   position_m.z(),
                                   ")"));
}

absl::StatusOr<Eigen::Isometry3d> MakePose(const Eigen::Vector3d& position_m,
                                           const Eigen::Vector4d& quaternion_xyzw) {
  if (absl::Status status = CheckPosition("position_m", position_m); !status.ok()) return status;
  if (!quaternion_xyzw.allFinite()) {
    return InvalidField(reason::kNonFinitePose,
                        "orientation",
                        "the orientation must be finite, got NaN or infinity");
  }
  const double norm = quaternion_xyzw.norm();
  if (std::abs(norm - 1.0) > kQuaternionNormTolerance) {
    return InvalidField(
        reason::kNotARotation,
        "orientation",
        absl::StrCat(
            "the quaternion must have norm 1 within ", kQuaternionNormTolerance, ", got ", norm));
  }
  const Eigen::Vector4d unit = quaternion_xyzw / norm;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = position_m;
  pose.linear() = Eigen::Quaterniond(unit.w(), unit.x(), unit.y(), unit.z()).toRotationMatrix();
  return pose;
}

Eigen::Isometry3d TransformOf(const Eigen::Vector3d& translation,
                              const Eigen::Vector3d& rotation_vector) {
  const double angle_rad = rotation_vector.norm();
  Eigen::Isometry3d transform(Eigen::Translation3d{translation});
  if (angle_rad > 0.0) transform.rotate(Eigen::AngleAxisd(angle_rad, rotation_vector / angle_rad));
  return transform;
}

double YawOf(const Eigen::Isometry3d& transform) {
  const Eigen::Vector3d x_axis = transform.linear().col(0);
  return std::atan2(x_axis.y(), x_axis.x());
}

}  // namespace steadymap
