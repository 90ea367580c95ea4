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
  /// Standard deviation of the claimed poses at the start of a session, metres and radians. 0 m:
  /// the claimed poses are exact.
  double sigma_m = 0.04;
  double sigma_rad = 0.009;
  /// Time in which the errors change, seconds: that of a Gauss-Markov process of first order.
  double correlation_s = 60.0;
  /// Error of the surface of the map, voxels.
  double surface_sigma_voxels = 0.2;
  /// A sample at so many standard deviations from the surface of the map has a quarter of its
  /// weight, and half of its pull.
  double max_sigmas = 3.0;
  /// A registration that is so unlikely under the prior is on other things: the square of its
  /// distance in standard deviations, for six degrees of freedom at 0.1 %.
  double max_prior_distance2 = 22.5;
  /// Largest angle between a sample and the surface that it is on, as a cosine.
  double min_normal_cosine = 0.7;
  /// Number of samples, and share of them with independent errors: neighbours have one bias.
  std::size_t max_samples = 800;
  double independent_share = 0.05;
  /// Time after which a camera shows something new, seconds. Frames in between count for less.
  double look_s = 0.2;
};

/// A frame at its claimed pose, and the objects that it may see.
struct FrameInMap {
  const SemanticCloud& cloud;
  const SampleGrid& samples;
  const std::vector<ObjectInView>& in_view;
};

/// Estimates the pose error of a sensor from frame to frame: an iterated extended Kalman filter in
/// six degrees of freedom, which registers each frame to the surface of the map (point to signed
/// distance; Bylow et al., RSS 2013) with the claimed pose as prior. Where the surface does not
/// determine the pose, such as along a wall, the prior does.
///
/// How good the claimed poses are differs between robots. A bank of filters (Magill, IEEE Trans.
/// Automatic Control 1965) assumes that errors change as fast as the parameters say, or 4 or 16
/// times more slowly, and weighs these hypotheses by the likelihood of the frames. So poses that
/// are accurate to a millimetre are not disturbed by the registration, which is not.
class PoseFilter {
 public:
  explicit PoseFilter(const PoseFilterParameters& parameters) : parameters_(parameters) {}

  /// Returns the pose error at a frame with capture time `time`. `last`: that of the sensor's last
  /// frame; none at the start of a session. The first frame of a map defines its world frame. A
  /// frame that fits only far from its claimed pose tells nothing.
  ///
  /// Cost: about 1 ms.
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
