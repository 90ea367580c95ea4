#include "client/bench/evaluation/composite/upright.h"

#include <algorithm>
#include <cstddef>

namespace steadymap {
namespace {

// Cosines of the largest tilt, of 45 degrees, and of the angle within which normals agree, of 8.
constexpr float kMinUpCosine = 0.707F;
constexpr float kAgreeingCosine = 0.99F;

constexpr std::size_t kMaxCandidates = 400;
constexpr int kRefinements = 10;

/// Returns the sum of the normals that agree with a direction.
Eigen::Vector3f SumNear(const Eigen::Vector3f& direction,
                        const std::vector<Eigen::Vector3f>& normals) {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (const Eigen::Vector3f& normal : normals) {
    if (normal.dot(direction) >= kAgreeingCosine) sum += normal;
  }
  return sum;
}

}  // namespace

Eigen::Quaterniond UprightRotation(const std::vector<Eigen::Vector3f>& normals) {
  std::vector<Eigen::Vector3f> upper;
  std::copy_if(
      normals.begin(), normals.end(), std::back_inserter(upper), [](const Eigen::Vector3f& normal) {
        return normal.z() >= kMinUpCosine;
      });
  if (upper.empty()) return Eigen::Quaterniond::Identity();
  Eigen::Vector3f up = Eigen::Vector3f::Zero();
  const std::size_t step = upper.size() / kMaxCandidates + 1;
  for (std::size_t i = 0; i < upper.size(); i += step) {
    const Eigen::Vector3f sum = SumNear(upper[i], upper);
    if (sum.squaredNorm() > up.squaredNorm()) up = sum;
  }
  for (int i = 0; i < kRefinements; ++i) up = SumNear(up.normalized(), upper);
  return Eigen::Quaterniond::FromTwoVectors(up.cast<double>(), Eigen::Vector3d::UnitZ());
}

}  // namespace steadymap
