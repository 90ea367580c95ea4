#pragma once

#include <filesystem>
#include <string>

#include <absl/status/statusor.h>

#include "core/geometry/geometry.h"
#include "core/types/timestamp.h"

/// The TorWIC-Mapping layout on disk, shared by the loader and the simulator's writer.
namespace steadymap {

/// The rig that took a recording.
struct TorwicCalibration {
  PinholeCamera camera;
  Eigen::Isometry3d T_base_camera = Eigen::Isometry3d::Identity();  ///< Optical frame to base.
  double metres_per_unit = 0.001;                                   ///< Of depth images.
};

/// The calibration of the public TorWIC recordings.
TorwicCalibration DefaultTorwicCalibration();

/// Reads `calibration.txt`: lines that start with # are comments; the others are
/// `w=640 h=360 fx=.. fy=.. cx=.. cy=..`, then `tx ty tz qx qy qz qw` of `T_base_camera`, then the
/// depth scale in metres per unit.
/// Errors: `NotFound`; `InvalidArgument` naming the file, the line and what was expected there.
absl::StatusOr<TorwicCalibration> LoadTorwicCalibration(const std::filesystem::path& file);

/// The text of a `calibration.txt` that reads back as the same calibration.
std::string FormatTorwicCalibration(const TorwicCalibration& calibration);

/// The text of a line of `poses.txt`, without a line end: `id sec nsec px py pz qx qy qz qw` of
/// `T_map_base`, with all the digits that a double has.
std::string FormatTorwicPose(std::size_t id, Timestamp time, const Eigen::Isometry3d& T_map_base);

}  // namespace steadymap
