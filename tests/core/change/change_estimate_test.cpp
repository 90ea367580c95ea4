// Compares the change by rays with the change by voxels of the paper, and tests scenes with known
// change.

#include "core/change/change_estimate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <random>

#include <gtest/gtest.h>

#include "tests/support/analytic_depth.h"
#include "tests/support/analytic_solid.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Plane;
using ::steadymap::testing::RangeFunction;
using ::steadymap::testing::RangeTo;
using ::steadymap::testing::Sphere;

constexpr int kSidePx = 48;
constexpr double kFocalPx = 90.0;
constexpr double kCenterPx = 0.5 * (kSidePx - 1);

/// Returns the depth along z of a surface, observed by a camera at the origin; 0 without a return.
Image<float> DepthOf(const RangeFunction& surface) {
  Image<float> depth_m(kSidePx, kSidePx);
  for (int v = 0; v < kSidePx; ++v) {
    for (int u = 0; u < kSidePx; ++u) {
      const Eigen::Vector3d ray((u - kCenterPx) / kFocalPx, (v - kCenterPx) / kFocalPx, 1.0);
      const double range_m = surface(Eigen::Vector3d::Zero(), ray);
      if (range_m > 0.0) depth_m.At(u, v) = static_cast<float>(range_m);
    }
  }
  return depth_m;
}

Image<float> DepthOfPlane(double depth_m) {
  return DepthOf(Plane(Eigen::Vector3d::UnitZ(), depth_m));
}

/// Returns a surface translated by `shift`. Both are in the camera frame.
RangeFunction Moved(const RangeFunction& surface, const Eigen::Vector3d& shift) {
  return [=](const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
    return surface(origin - shift, direction);
  };
}

/// Returns the depths of both surfaces at the pixel of a voxel centre, or nothing if either surface
/// has no return there.
std::optional<std::pair<double, double>> DepthsAt(const Eigen::Vector3d& voxel_camera,
                                                  const Image<float>& object_depth_m,
                                                  const Image<float>& observed_depth_m) {
  const double u = kFocalPx * voxel_camera.x() / voxel_camera.z() + kCenterPx;
  const double v = kFocalPx * voxel_camera.y() / voxel_camera.z() + kCenterPx;
  if (u <= -0.5 || v <= -0.5 || u >= kSidePx - 0.5 || v >= kSidePx - 0.5) return std::nullopt;
  const int column = static_cast<int>(std::lround(u));
  const int row = static_cast<int>(std::lround(v));
  const double object_m = static_cast<double>(object_depth_m.At(column, row));
  const double observed_m = static_cast<double>(observed_depth_m.At(column, row));
  if (object_m == 0.0 || observed_m == 0.0) return std::nullopt;
  return std::pair(object_m, observed_m);
}

/// Computes the magnitude of the sum of the paper: two truncated projective distances at each voxel
/// of a grid in the camera frame. Voxels that are a truncation distance or more in front of both
/// surfaces belong to neither volume.
std::optional<double> ChangeByVoxels(const Image<float>& object_depth_m,
                                     const Image<float>& observed_depth_m,
                                     double voxel_size_m,
                                     double farthest_m,
                                     const ChangeParameters& parameters) {
  const double truncation_m = parameters.truncation_m;
  const double half_width = (kCenterPx + 1.0) / kFocalPx;
  std::size_t voxels = 0;
  double sum_m = 0.0;
  const auto layers = static_cast<int>(std::ceil(farthest_m / voxel_size_m - 0.5));
  for (int k = 0; k < layers; ++k) {
    const double z = (k + 0.5) * voxel_size_m;
    const auto half_side = static_cast<int>(std::ceil(half_width * z / voxel_size_m));
    for (int j = -half_side; j <= half_side; ++j) {
      for (int i = -half_side; i <= half_side; ++i) {
        const auto depths =
            DepthsAt({i * voxel_size_m, j * voxel_size_m, z}, object_depth_m, observed_depth_m);
        if (!depths) continue;
        const double object = std::min(depths->first - z, truncation_m);
        const double observed = std::min(depths->second - z, truncation_m);
        const bool is_known = object < truncation_m || observed < truncation_m;
        if (!is_known || object <= 0.0 || observed <= 0.0) continue;
        ++voxels;
        sum_m += std::abs(observed - object);
      }
    }
  }
  if (voxels == 0) return std::nullopt;
  return parameters.change_scale * sum_m / static_cast<double>(voxels);
}

/// Planes, boxes and spheres up to 1.5 m away. No face is parallel to the voxel layers, since a
/// whole layer would then begin or end at the face at once.
class RandomScenes {
 public:
  explicit RandomScenes(std::uint64_t seed) : random_(seed) {}

  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

  RangeFunction Surface(int kind) {
    const double depth_m = Uniform(0.7, 1.2);
    const Eigen::Vector3d center(Uniform(-0.1, 0.1), Uniform(-0.1, 0.1), depth_m);
    if (kind == 0) {
      const Eigen::Vector3d normal =
          Eigen::Vector3d(Uniform(-0.5, 0.5), Uniform(-0.5, 0.5), 1.0).normalized();
      return Plane(normal, depth_m);
    }
    if (kind == 1) return Sphere(center, Uniform(0.15, 0.3));
    const Eigen::Vector3d half_m(Uniform(0.1, 0.2), Uniform(0.1, 0.2), Uniform(0.1, 0.2));
    const Eigen::Vector3d axis = Eigen::Vector3d(Uniform(-1.0, 1.0), 1.0, 0.0).normalized();
    const Eigen::Matrix3d turn(Eigen::AngleAxisd(Uniform(0.3, 1.2), axis));
    return [box = RangeTo({Box(-half_m, half_m)}), turn, center](const Eigen::Vector3d& origin,
                                                                 const Eigen::Vector3d& direction) {
      return box(turn.transpose() * (origin - center), turn.transpose() * direction);
    };
  }

  /// Returns a shift mostly along z.
  Eigen::Vector3d Shift() {
    const double along_m = Uniform(0.04, 0.25) * (Uniform(0.0, 1.0) < 0.5 ? -1.0 : 1.0);
    return {Uniform(-0.02, 0.02), Uniform(-0.02, 0.02), along_m};
  }

 private:
  std::mt19937_64 random_;
};

/// Returns the change between two depth images.
std::optional<double> ChangeOf(const Image<float>& object_depth_m,
                               const Image<float>& observed_depth_m,
                               const ChangeParameters& parameters) {
  ChangeSum sum(parameters);
  for (std::size_t i = 0; i < object_depth_m.size(); ++i) {
    sum.AddRay(static_cast<double>(object_depth_m.data()[i]),
               static_cast<double>(observed_depth_m.data()[i]));
  }
  return sum.Change();
}

ChangeParameters Untruncated() {
  ChangeParameters parameters;
  parameters.truncation_m = std::numeric_limits<double>::infinity();
  return parameters;
}

void CompareWithVoxels(double truncation_m) {
  RandomScenes scenes(11);
  ChangeParameters parameters;
  parameters.truncation_m = truncation_m;
  for (int i = 0; i < 9; ++i) {
    const RangeFunction surface = scenes.Surface(i % 3);
    const Eigen::Vector3d shift = scenes.Shift();
    const Image<float> object_m = DepthOf(surface);
    const Image<float> observed_m = DepthOf(Moved(surface, shift));
    const std::optional<double> by_rays = ChangeOf(object_m, observed_m, parameters);
    const std::optional<double> by_voxels =
        ChangeByVoxels(object_m, observed_m, 0.008, 1.8, parameters);
    ASSERT_TRUE(by_rays && by_voxels) << i;
    EXPECT_NEAR(*by_rays, *by_voxels, 0.01 * *by_voxels) << i;
  }
}

TEST(ChangeSum, EqualsTheSumOverVoxels) {
  CompareWithVoxels(std::numeric_limits<double>::infinity());
}

TEST(ChangeSum, EqualsTheSumOverTruncatedVoxels) {
  CompareWithVoxels(0.2);
  CompareWithVoxels(0.1);
}

TEST(ChangeSum, OfAShiftedPlaneIsTheScaledShift) {
  const Image<float> object_m = DepthOfPlane(2.0);
  for (const double scale : {1.0, 1.6}) {
    ChangeParameters parameters = Untruncated();
    parameters.change_scale = scale;
    for (const double nearer_m : {0.9, 0.3, 0.04, 0.0, -0.04, -0.3, -1.5}) {
      const std::optional<double> change =
          ChangeOf(object_m, DepthOfPlane(2.0 - nearer_m), parameters);
      ASSERT_TRUE(change.has_value());
      EXPECT_NEAR(*change, scale * std::abs(nearer_m), 1e-6);
    }
  }
}

TEST(ChangeSum, NeverExceedsHalfATruncationIfThereIsOne) {
  // The plane is far away, so voxels are evenly distributed along a ray and the limit is that of a
  // line.
  ChangeParameters parameters;
  parameters.truncation_m = 0.2;
  for (const double shift_m : {0.2, 0.5, 5.0}) {
    const std::optional<double> change =
        ChangeOf(DepthOfPlane(50.0), DepthOfPlane(50.0 + shift_m), parameters);
    ASSERT_TRUE(change.has_value());
    EXPECT_NEAR(*change, 1.6 * 0.1, 0.001) << shift_m;
  }
}

TEST(ChangeSum, IsNoneWhereNothingIsShared) {
  Image<float> left(4, 2);
  Image<float> right(4, 2);
  EXPECT_FALSE(ChangeOf(left, right, ChangeParameters()).has_value());
  left.At(0, 0) = 1.0F;
  right.At(3, 0) = 1.0F;
  EXPECT_FALSE(ChangeOf(left, right, ChangeParameters()).has_value());
  right.At(0, 0) = 1.0F;
  EXPECT_EQ(ChangeOf(left, right, ChangeParameters()), 0.0);
  EXPECT_FALSE(ChangeOf(Image<float>(), Image<float>(), ChangeParameters()).has_value());
}

TEST(ChangeSum, IgnoresDepthsThatAreNone) {
  ChangeSum sum{Untruncated()};
  for (const double none : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    sum.AddRay(none, 2.0);
    sum.AddRay(2.0, none);
  }
  EXPECT_FALSE(sum.Change().has_value());
  sum.AddRay(2.0, 1.5);
  EXPECT_NEAR(*sum.Change(), 1.6 * 0.5, 1e-12);
}

}  // namespace
}  // namespace steadymap
