#include "core/change/yaw_change.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace steadymap {
namespace {

// Standard deviation of one distance, metres. More than the sensor's noise: neighbouring distances
// err alike.
constexpr double kOffsetErrorM = 0.05;

// How far things may be shifted aside, metres: what the surface says nothing of.
constexpr double kShiftM = 0.1;

}  // namespace

void YawChangeSum::Add(const Eigen::Vector3d& position,
                       const Eigen::Vector3d& normal,
                       double offset_m) {
  if (count_ == 0) origin_ = position;
  ++count_;
  const Eigen::Vector3d arm = position - origin_;
  const Eigen::Vector3d row(arm.x() * normal.y() - arm.y() * normal.x(), normal.x(), normal.y());
  information_ += row * row.transpose();
  projected_ += offset_m * row;
}

YawChangeSum::Turn YawChangeSum::Estimate() const {
  constexpr double kPrior = (kOffsetErrorM / kShiftM) * (kOffsetErrorM / kShiftM);
  Eigen::Matrix3d information = information_;
  information.diagonal() += Eigen::Vector3d(1e-9, kPrior, kPrior);
  const Eigen::Matrix3d covariance = information.inverse();
  Turn turn;
  turn.angle_rad = covariance.row(0).dot(projected_);
  turn.error_rad = kOffsetErrorM * std::sqrt(covariance(0, 0));
  // What the shift could explain as well is not the turn's.
  turn.offset_m =
      std::abs(turn.angle_rad) /
      std::sqrt(covariance(0, 0) * static_cast<double>(std::max<std::size_t>(count_, 1)));
  return turn;
}

bool YawChangeSum::Exceeds(const YawChangeParameters& parameters) const {
  if (parameters.turned_rad <= 0.0) return false;
  const Turn turn = Estimate();
  return turn.error_rad <= parameters.max_error_rad &&
         std::abs(turn.angle_rad) - turn.error_rad > parameters.turned_rad &&
         turn.offset_m >= parameters.min_offset_m;
}

}  // namespace steadymap
