#include "core/map/pose_error.h"

#include "core/geometry/geometry.h"

namespace steadymap {

Eigen::Isometry3d PoseError::Correct(const Eigen::Isometry3d& T_world_camera) const {
  const Eigen::Isometry3d turn = TransformOf(Eigen::Vector3d::Zero(), mean.tail<3>());
  Eigen::Isometry3d corrected = T_world_camera;
  corrected.linear() = turn.linear() * T_world_camera.linear();
  corrected.translation() += mean.head<3>();
  return corrected;
}

PoseError PoseErrorEstimate::Combined() const {
  PoseError combined;
  for (const PoseErrorHypothesis& hypothesis : hypotheses) {
    combined.mean += hypothesis.probability * hypothesis.error.mean;
  }
  for (const PoseErrorHypothesis& hypothesis : hypotheses) {
    const PoseErrorVector difference = hypothesis.error.mean - combined.mean;
    combined.covariance += hypothesis.probability *
                           (hypothesis.error.covariance + difference * difference.transpose());
  }
  return combined;
}

void PoseErrorEstimate::Move(const Eigen::Isometry3d& motion,
                             const Eigen::Vector3d& claimed_camera_world) {
  for (PoseErrorHypothesis& hypothesis : hypotheses) {
    PoseErrorVector& mean = hypothesis.error.mean;
    const Eigen::Isometry3d turn = TransformOf(Eigen::Vector3d::Zero(), mean.tail<3>());
    const Eigen::AngleAxisd moved_turn(motion.linear() * turn.linear());
    mean.head<3>() = motion * (claimed_camera_world + mean.head<3>()) - claimed_camera_world;
    mean.tail<3>() = moved_turn.angle() * moved_turn.axis();
  }
}

}  // namespace steadymap
