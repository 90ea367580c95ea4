#pragma once

#include <filesystem>
#include <string>

#include <absl/status/statusor.h>

#include "core/geometry/geometry.h"
#include "core/types/timestamp.h"

/// The TorWIC-Mapping layout on disk, shared by the loader and the simulator's writer.
namespace steadymap {

/// The calibration of the camera rig of a recording.
struct TorwicCalibration {
  PinholeCamera camera;
  /// Transforms the optical frame to the base frame.
  Eigen::Isometry3d T_base_camera = Eigen::Isometry3d::Identity();
  double metres_per_unit = 0.001;  ///< Unit of depth images.
};

/// Returns the calibration of the public TorWIC recordings.
TorwicCalibration DefaultTorwicCalibration();

/// Reads `calibration.txt`. Lines that start with # are comments. The other lines are `w=640 h=360
/// fx=.. fy=.. cx=.. cy=..`, then `tx ty tz qx qy qz qw` of `T_base_camera`, then the depth scale
/// in metres per unit. Errors: `NotFound`; `InvalidArgument` with the file, the line and the
/// expected content in the message.
absl::StatusOr<TorwicCalibration> LoadTorwicCalibration(const std::filesystem::path& file);

/// Returns the text of a `calibration.txt` that `LoadTorwicCalibration` reads as an equal
/// calibration.
std::string FormatTorwicCalibration(const TorwicCalibration& calibration);

/// Returns a line of `poses.txt`, without a line end: `id sec nsec px py pz qx qy qz qw` of
/// `T_map_base`, with enough digits to preserve every bit.
std::string FormatTorwicPose(std::size_t id, Timestamp time, const Eigen::Isometry3d& T_map_base);

}  // namespace steadymap
