#include "core/registration/point_alignment.h"

#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace steadymap {
namespace {

// Margin of a descent beyond the range of searched yaws: the optimum can lie at the border of the
// range.
constexpr double kYawMarginRad = 0.1;

// Steps shorter than this count as converged, voxels.
constexpr double kSettledVoxels = 0.005;

constexpr double kFirstDamping = 1e-4;
constexpr double kDampingRise = 30.0;
constexpr double kDampingFall = 0.1;

// Maximum share of the known points that may become unknown by a step.
constexpr double kMaxLostShare = 0.2;

/// True if a step reduced the mean loss of the known points. Points that become known or unknown
/// are ignored, up to `kMaxLostShare`.
bool IsBetter(const AlignmentFit& next, const AlignmentFit& last) {
  return next.known_cost<last.known_cost&& static_cast<double>(next.known)>(1.0 - kMaxLostShare) *
         static_cast<double>(last.known);
}

using Solver = Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>;

}  // namespace

PointAlignment::PointAlignment(TsdfSampler* sampler,
                               const Eigen::Vector3d& centroid,
                               double lever_m,
                               const RegistrationParameters& parameters)
    : sampler_(sampler),
      centroid_(centroid),
      lever_m_(lever_m),
      parameters_(parameters),
      inlier_distance_m_(parameters.inlier_distance_voxels * sampler->scale().voxel_size_m) {}

double PointAlignment::Loss(double distance_m) const {
  const double square = distance_m * distance_m;
  return square / (square + inlier_distance_m_ * inlier_distance_m_);
}

AlignmentFit PointAlignment::Linearize(std::span<const Eigen::Vector3d> offsets,
                                       const UprightMotion& motion) {
  AlignmentFit fit;
  if (offsets.empty()) return fit;
  const Eigen::Matrix3d rotation = YawRotation(motion.yaw_rad);
  const Eigen::Vector3d center = centroid_ + motion.shift_m;
  double loss_sum = 0.0;
  double weight_sum = 0.0;
  for (const Eigen::Vector3d& offset : offsets) {
    const Eigen::Vector3d turned = rotation * offset;
    const DistanceSample sample = sampler_->Sample(center + turned);
    if (!sample.known) continue;
    ++fit.known;
    if (std::abs(sample.distance_m) > inlier_distance_m_) ++fit.outliers;
    const double loss = Loss(sample.distance_m);
    loss_sum += loss;
    const double weight = (1.0 - loss) * (1.0 - loss);
    weight_sum += weight;
    const Eigen::Vector3d& normal = sample.gradient;
    const double turn = (normal.y() * turned.x() - normal.x() * turned.y()) / lever_m_;
    const Eigen::Vector4d jacobian(normal.x(), normal.y(), normal.z(), turn);
    const Eigen::Vector4d weighted = weight * jacobian;
    fit.information.noalias() += weighted * jacobian.transpose();
    fit.gradient += weighted * sample.distance_m;
  }
  const double unknown = static_cast<double>(offsets.size() - fit.known);
  fit.cost = (loss_sum + unknown) / static_cast<double>(offsets.size());
  if (fit.known > 0) fit.known_cost = loss_sum / static_cast<double>(fit.known);
  if (weight_sum > 0.0) {
    fit.information /= weight_sum;
    fit.gradient /= weight_sum;
  }
  return fit;
}

Eigen::Vector4d PointAlignment::Step(const AlignmentFit& fit, double damping) const {
  const Solver solver(fit.information);
  Eigen::Vector4d step = Eigen::Vector4d::Zero();
  for (int i = 0; i < 4; ++i) {
    const double share = solver.eigenvalues()[i];
    if (!(share > parameters_.min_direction_share)) continue;
    const Eigen::Vector4d direction = solver.eigenvectors().col(i);
    step -= direction * (direction.dot(fit.gradient) / (share + damping));
  }
  return step;
}

UprightMotion PointAlignment::DeterminedPart(const AlignmentFit& fit,
                                             const UprightMotion& motion) const {
  const Solver solver(fit.information);
  Eigen::Vector4d whole;
  whole << motion.shift_m, motion.yaw_rad * lever_m_;
  Eigen::Vector4d part = Eigen::Vector4d::Zero();
  for (int i = 0; i < 4; ++i) {
    if (!(solver.eigenvalues()[i] > parameters_.min_direction_share)) continue;
    const Eigen::Vector4d direction = solver.eigenvectors().col(i);
    part += direction * direction.dot(whole);
  }
  return Advance({}, part);
}

AlignmentDescent PointAlignment::Descend(std::span<const Eigen::Vector3d> offsets,
                                         const UprightMotion& start,
                                         int max_iterations) {
  AlignmentDescent descent;
  descent.motion = start;
  descent.fit = Linearize(offsets, start);
  const double settled_m = kSettledVoxels * sampler_->scale().voxel_size_m;
  double damping = kFirstDamping;
  while (descent.fit.known > 0 && descent.iterations < max_iterations) {
    const Eigen::Vector4d step = Step(descent.fit, damping);
    if (step.norm() < settled_m) {
      descent.converged = true;
      break;
    }
    ++descent.iterations;
    const UprightMotion next = Advance(descent.motion, step);
    AlignmentFit next_fit;
    if (WithinBounds(next)) next_fit = Linearize(offsets, next);
    if (IsBetter(next_fit, descent.fit)) {
      descent.motion = next;
      descent.fit = next_fit;
      damping *= kDampingFall;
    } else {
      damping *= kDampingRise;
    }
  }
  return descent;
}

UprightMotion PointAlignment::Advance(const UprightMotion& motion,
                                      const Eigen::Vector4d& step) const {
  return {motion.shift_m + step.head<3>(), motion.yaw_rad + step[3] / lever_m_};
}

bool PointAlignment::WithinBounds(const UprightMotion& motion) const {
  return motion.shift_m.norm() <= parameters_.search_distance_m + sampler_->scale().truncation_m &&
         std::abs(motion.yaw_rad) <= parameters_.search_yaw_rad + kYawMarginRad;
}

}  // namespace steadymap
