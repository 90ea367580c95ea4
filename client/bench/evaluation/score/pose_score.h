#pragma once

#include <cstddef>
#include <string>

#include "client/bench/evaluation/truth/stamped_pose.h"

namespace steadymap {

/// Error of the camera poses of one or more runs.
struct PoseScore {
  double square_sum_m2 = 0.0;  ///< Of the distances of points from their true places.
  std::size_t points = 0;
  double square_sum_sigmas2 = 0.0;  ///< Of the Mahalanobis distances of poses with a covariance.
  std::size_t stated_poses = 0;     ///< Poses with a covariance.

  /// Root mean square distance, metres; NaN without points.
  double rms_m() const;

  /// Root mean square error of a coordinate of a pose, in standard deviations that its covariance
  /// states; 1 if the covariances are right, NaN without any. The first pose has no error: it
  /// defines the world frame of the map.
  double rms_sigmas() const;

  PoseScore& operator+=(const PoseScore& other);
};

/// Returns the root mean square in millimetres; `-` without points.
std::string MillimetreText(const PoseScore& score);

/// Returns the root mean square in standard deviations; `-` if no pose has a covariance.
std::string SigmaText(const PoseScore& score);

/// Scores the poses at whose times the truth has a pose. Per pose, three points count: the camera
/// and, since a wrong rotation displaces what the camera sees, two points 2 m in front of it, on
/// the axis and 1 m beside it. A motion common to all points, by which their distances are least,
/// is no error: no map can observe it. Source: absolute trajectory error; Sturm et al., A benchmark
/// for the evaluation of RGB-D SLAM systems, IROS 2012.
PoseScore ScorePoses(const CameraPath& truth, const CameraPath& poses);

}  // namespace steadymap
