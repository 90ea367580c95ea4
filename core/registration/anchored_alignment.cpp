#include "core/registration/anchored_alignment.h"

#include <cmath>

namespace steadymap {
namespace {

constexpr int kMaxIterations = 20;
constexpr double kNegligibleStepM = 1e-5;

/// Votes of anchors on a motion; all of one set of anchors.
class AnchorVotes {
 public:
  AnchorVotes(std::span<const AnchorMatches> anchors, double scale_m, const AlignmentPrior& prior)
      : anchors_(anchors), scale_m_(scale_m), prior_(prior) {
    std::size_t count = 0;
    for (const AnchorMatches& anchor : anchors_) {
      for (const PlaneMatch& match : anchor) {
        center_world_ += match.point_world;
        ++count;
      }
    }
    if (count > 0) center_world_ /= static_cast<double>(count);
    for (const AnchorMatches& anchor : anchors_) {
      for (const PlaneMatch& match : anchor) {
        lever_m_ += (match.point_world - center_world_).head<2>().squaredNorm();
      }
    }
    lever_m_ = count > 0 ? std::sqrt(lever_m_ / static_cast<double>(count)) : 1.0;
  }

  AnchorAlignment AlignmentAt(const Eigen::Isometry3d& motion) const {
    AnchorAlignment alignment{motion, center_world_, lever_m_};
    for (const AnchorMatches& anchor : anchors_) {
      if (anchor.empty() || MeanSquare(anchor, motion) >= scale_m_ * scale_m_) continue;
      ++alignment.agreeing;
      for (const PlaneMatch& match : anchor) {
        const Eigen::Vector4d jacobian = JacobianOf(match, motion);
        alignment.information += jacobian * jacobian.transpose() / CountOf(anchor);
      }
    }
    return alignment;
  }

  /// Returns the loss of all votes at a motion: 0 to the number of votes.
  double LossAt(const Eigen::Isometry3d& motion) const {
    double loss = prior_.votes * Loss(PriorSquare(motion));
    for (const AnchorMatches& anchor : anchors_) loss += Loss(MeanSquare(anchor, motion));
    return loss;
  }

  /// Minimises the loss by reweighted least squares.
  Eigen::Isometry3d Descend(Eigen::Isometry3d motion) const {
    for (int i = 0; i < kMaxIterations; ++i) {
      Eigen::Matrix4d information = Eigen::Matrix4d::Identity() * 1e-9;
      Eigen::Vector4d gradient = Eigen::Vector4d::Zero();
      AddPrior(motion, &information, &gradient);
      for (const AnchorMatches& anchor : anchors_) {
        const double weight = Weight(MeanSquare(anchor, motion)) / CountOf(anchor);
        for (const PlaneMatch& match : anchor) {
          const Eigen::Vector3d point = motion * match.point_world;
          const Eigen::Vector4d jacobian = JacobianOf(match, motion);
          const double residual = match.normal_world.dot(point - match.target_world);
          information += weight * jacobian * jacobian.transpose();
          gradient += weight * residual * jacobian;
        }
      }
      const Eigen::Vector4d step = -information.ldlt().solve(gradient);
      motion = Step(step, motion);
      if (step.head<3>().norm() + lever_m_ * std::abs(step[3]) < kNegligibleStepM) break;
    }
    return motion;
  }

 private:
  static double CountOf(const AnchorMatches& anchor) { return static_cast<double>(anchor.size()); }

  double Loss(double square_m2) const { return square_m2 / (square_m2 + scale_m_ * scale_m_); }

  double Weight(double square_m2) const {
    const double ratio = 1.0 + square_m2 / (scale_m_ * scale_m_);
    return 1.0 / (ratio * ratio);
  }

  static double MeanSquare(const AnchorMatches& anchor, const Eigen::Isometry3d& motion) {
    double sum = 0.0;
    for (const PlaneMatch& match : anchor) {
      const double residual =
          match.normal_world.dot(motion * match.point_world - match.target_world);
      sum += residual * residual;
    }
    return anchor.empty() ? 0.0 : sum / CountOf(anchor);
  }

  Eigen::Vector4d JacobianOf(const PlaneMatch& match, const Eigen::Isometry3d& motion) const {
    const Eigen::Vector3d arm = motion.linear() * (match.point_world - center_world_);
    Eigen::Vector4d jacobian;
    jacobian << match.normal_world, match.normal_world.dot(Eigen::Vector3d::UnitZ().cross(arm));
    return jacobian;
  }

  static double YawOfMotion(const Eigen::Isometry3d& motion) {
    return std::atan2(motion.linear()(1, 0), motion.linear()(0, 0));
  }

  /// Returns the shift of the centre and the yaw beyond those of the prior.
  Eigen::Vector4d BeyondPrior(const Eigen::Isometry3d& motion) const {
    Eigen::Vector4d beyond;
    beyond << motion * center_world_ - prior_.motion * center_world_,
        YawOfMotion(prior_.motion.inverse() * motion);
    return beyond;
  }

  double PriorSquare(const Eigen::Isometry3d& motion) const {
    Eigen::Vector4d beyond = BeyondPrior(motion);
    beyond[3] *= lever_m_;
    return beyond.squaredNorm();
  }

  void AddPrior(const Eigen::Isometry3d& motion,
                Eigen::Matrix4d* information,
                Eigen::Vector4d* gradient) const {
    const double weight = prior_.votes * Weight(PriorSquare(motion));
    const Eigen::Vector4d scale(weight, weight, weight, weight * lever_m_ * lever_m_);
    *information += scale.asDiagonal();
    *gradient += scale.cwiseProduct(BeyondPrior(motion));
  }

  /// Turns the moved points about their moved centre, then shifts them.
  Eigen::Isometry3d Step(const Eigen::Vector4d& step, const Eigen::Isometry3d& motion) const {
    const Eigen::Vector3d center = motion * center_world_;
    const Eigen::Isometry3d turn = Eigen::Translation3d(center + step.head<3>()) *
                                   Eigen::AngleAxisd(step[3], Eigen::Vector3d::UnitZ()) *
                                   Eigen::Translation3d(-center);
    return turn * motion;
  }

  std::span<const AnchorMatches> anchors_;
  double scale_m_;
  AlignmentPrior prior_;
  Eigen::Vector3d center_world_ = Eigen::Vector3d::Zero();
  double lever_m_ = 0.0;
};

}  // namespace

AnchorAlignment AlignToAnchors(std::span<const AnchorMatches> anchors,
                               std::span<const Eigen::Isometry3d> starts,
                               double scale_m,
                               const AlignmentPrior& prior) {
  const AnchorVotes votes(anchors, scale_m, prior);
  Eigen::Isometry3d best = votes.Descend(prior.motion);
  double least_loss = votes.LossAt(best);
  for (const Eigen::Isometry3d& start : starts) {
    const Eigen::Isometry3d motion = votes.Descend(start);
    const double loss = votes.LossAt(motion);
    if (loss >= least_loss) continue;
    best = motion;
    least_loss = loss;
  }
  return votes.AlignmentAt(best);
}

}  // namespace steadymap
