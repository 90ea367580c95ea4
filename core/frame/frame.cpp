#include "core/frame/frame.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <absl/strings/str_cat.h>

#include "core/types/error.h"

namespace steadymap {
namespace {

constexpr double kMinMetresPerUnit = 1e-6;
constexpr double kMaxMetresPerUnit = 1e-1;

// The rounding error of a product of a few double-precision rotations.
constexpr double kRotationTolerance = 1e-6;

template <typename Pixel>
absl::Status CheckSize(const char* field, const Image<Pixel>& image, const PinholeCamera& camera) {
  if (image.width_px() == camera.width_px && image.height_px() == camera.height_px) {
    return absl::OkStatus();
  }
  return InvalidField(reason::kImageSizeMismatch,
                      field,
                      absl::StrCat(field,
                                   " must measure ",
                                   camera.width_px,
                                   " x ",
                                   camera.height_px,
                                   " pixels, the size in the intrinsics, got ",
                                   image.width_px(),
                                   " x ",
                                   image.height_px()));
}

absl::Status CheckSizes(const Frame& frame) {
  absl::Status status = CheckSize("depth", frame.depth.units, frame.camera);
  if (status.ok() && !frame.labels.empty()) {
    status = CheckSize("labels", frame.labels, frame.camera);
  }
  if (status.ok() && !frame.instances.empty()) {
    status = CheckSize("instances", frame.instances, frame.camera);
  }
  if (status.ok() && !frame.color.empty()) status = CheckSize("color", frame.color, frame.camera);
  return status;
}

absl::Status CheckLabels(const Image<std::uint16_t>& labels, const KnownLabels& known) {
  std::uint16_t highest = 0;
  const std::uint16_t* pixels = labels.data();
  // A plain reduction, which the compiler vectorises.
  for (std::size_t i = 0; i < labels.size(); ++i) highest = std::max(highest, pixels[i]);
  std::optional<std::uint16_t> unknown;
  if (highest >= known.limit()) {
    unknown = highest;
  } else if (!known.is_dense()) {
    for (std::size_t i = 0; i < labels.size() && !unknown; ++i) {
      if (!known.Contains(pixels[i])) unknown = pixels[i];
    }
  }
  if (!unknown) return absl::OkStatus();
  return InvalidField(reason::kLabelOutOfRange,
                      "labels",
                      absl::StrCat("labels must be in the map's class table or 0, got ", *unknown));
}

absl::Status CheckPose(const Eigen::Isometry3d& T_world_camera) {
  if (absl::Status status = CheckPosition("world_from_camera", T_world_camera.translation());
      !status.ok()) {
    return status;
  }
  const Eigen::Matrix3d R_world_camera = T_world_camera.linear();
  if (!R_world_camera.allFinite()) {
    return InvalidField(reason::kNonFinitePose,
                        "world_from_camera",
                        "the rotation must be finite, got NaN or infinity");
  }
  const double deviation =
      (R_world_camera.transpose() * R_world_camera - Eigen::Matrix3d::Identity())
          .cwiseAbs()
          .maxCoeff();
  if (deviation <= kRotationTolerance && R_world_camera.determinant() > 0.0) {
    return absl::OkStatus();
  }
  return InvalidField(
      reason::kNotARotation,
      "world_from_camera",
      absl::StrCat("the linear part of the pose must be a rotation, got a deviation of ",
                   deviation,
                   " from orthogonality and determinant ",
                   R_world_camera.determinant()));
}

}  // namespace

absl::Status ValidateFrame(const Frame& frame, const KnownLabels& labels) {
  absl::Status status = WithFieldPrefix(ValidateCamera(frame.camera), "intrinsics");
  if (!status.ok()) return status;
  // The comparisons reject NaN.
  if (!(frame.depth.metres_per_unit >= kMinMetresPerUnit &&
        frame.depth.metres_per_unit <= kMaxMetresPerUnit)) {
    return InvalidField(reason::kBadDepthEncoding,
                        "depth.metres_per_unit",
                        absl::StrCat("metres_per_unit must lie in [",
                                     kMinMetresPerUnit,
                                     ", ",
                                     kMaxMetresPerUnit,
                                     "], got ",
                                     frame.depth.metres_per_unit));
  }
  status = CheckPose(frame.T_world_camera);
  if (status.ok()) status = CheckSizes(frame);
  if (status.ok()) status = CheckLabels(frame.labels, labels);
  return status;
}

}  // namespace steadymap
