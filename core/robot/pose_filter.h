#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/association/association.h"
#include "core/association/sample_grid.h"
#include "core/integration/semantic_cloud.h"
#include "core/map/pose_error.h"
#include "core/working/working_map.h"

namespace steadymap {

/// The model of the pose errors of a sensor, and of what a frame tells of them.
struct PoseFilterParameters {
  /// Standard deviation of the claimed poses at the start of a session, metres and radians, at
  /// least 0.0001.
  double sigma_m = 0.04;
  double sigma_rad = 0.009;
  /// Time in which the errors change, seconds: that of a Gauss-Markov process of first order.
  double correlation_s = 60.0;
  /// Error of the surface of the map, voxels.
  double surface_sigma_voxels = 0.2;
  /// A sample at so many standard deviations from the surface of the map has a quarter of the
  /// weight of one on it. Surface is looked for as far away as so many standard deviations of the
  /// pose error. A registration further from the claimed pose fits the frame to other surface.
  double max_sigmas = 3.0;
  /// Standard deviation of the place of an object that nobody moved, metres. All samples of an
  /// object have half their weight if they fit its surface only after a displacement by one
  /// standard deviation of this place and the pose error together.
  double place_sigma_m = kPlaceSigmaM;
  /// Largest angle between a sample and the surface that it is on, as a cosine.
  double min_normal_cosine = 0.7;
  /// Number of registered samples, if the frame has them; up to four times as many, since every
  /// n-th row and column is taken.
  std::size_t min_samples = 800;
  /// Weight of surface that only the current session has seen, as a share of that of known surface:
  /// it is off by the errors of the poses from which it was seen. The background is known where a
  /// known object is in view.
  double session_share = 0.05;
  /// Time after which a camera shows something new, seconds. Frames in between count for less.
  double look_s = 0.15;

  friend bool operator==(const PoseFilterParameters&, const PoseFilterParameters&) = default;
};

/// A frame at its claimed pose, and the objects that it may see.
struct FrameInMap {
  const SemanticCloud& cloud;
  const SampleGrid& samples;
  const std::vector<ObjectInView>& in_view;
};

/// Estimates the pose error of a sensor from frame to frame: an iterated extended Kalman filter in
/// six degrees of freedom, which registers each frame to the surface of the map (point to signed
/// distance, `core/README.md`) with the claimed pose as prior. Where the surface does not
/// determine the pose, such as along a wall, the prior does.
///
/// How good the claimed poses are differs between robots. A bank of filters assumes that errors
/// change as fast as the parameters say, or 4 or 16 times more slowly, and weighs these hypotheses
/// by the likelihood of the frames. So the registration hardly disturbs poses that are more
/// accurate than itself.
class PoseFilter {
 public:
  explicit PoseFilter(const PoseFilterParameters& parameters) : parameters_(parameters) {}

  /// Returns the pose error at a frame with capture time `time`. `last`: that of the sensor's last
  /// frame; none at the start of a session. The first frame of a map defines its world frame. A
  /// frame tells nothing if it fits only far from its claimed pose, or if its registration does not
  /// converge: then it depends on which surface each sample is taken for.
  PoseErrorEstimate Update(const std::optional<PoseErrorEstimate>& last,
                           Timestamp time,
                           const FrameInMap& frame,
                           const WorkingMap& map) const;

 private:
  Eigen::Matrix<double, 6, 6> Prior() const;
  PoseErrorEstimate Predict(const std::optional<PoseErrorEstimate>& last, Timestamp time) const;

  PoseFilterParameters parameters_;
};

}  // namespace steadymap
