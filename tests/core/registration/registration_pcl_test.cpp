// Compares registration with the point-to-plane ICP of PCL. PCL's ICP has six degrees of freedom,
// exact surface points instead of a volume and no truncation, and takes some hundred times as long.

#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <pcl/point_types.h>
#include <pcl/registration/icp.h>

#include "core/registration/registration.h"
#include "tests/support/analytic_solid.h"
#include "tests/support/default_scale.h"

namespace steadymap {
namespace {

using ::steadymap::testing::DistanceFrom;
using ::steadymap::testing::kScale;
using ::steadymap::testing::LooksAround;
using ::steadymap::testing::MakeVolume;
using ::steadymap::testing::RandomMotionAbout;
using ::steadymap::testing::Solid;
using ::steadymap::testing::SurfaceView;
using ::steadymap::testing::ThingsToLookAt;
using ::steadymap::testing::WithNoise;

using Cloud = pcl::PointCloud<pcl::PointNormal>;

constexpr double kSpacingRad = 0.02;

/// Maximum mean distance of corresponding points at which two registrations agree: the error that
/// each may have (from the targets for known motions).
constexpr double kAgreementM = 0.01;

Eigen::Vector3d NormalAt(const Solid& solid, const Eigen::Vector3d& point) {
  constexpr double kStepM = 1e-4;
  Eigen::Vector3d gradient;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d step = kStepM * Eigen::Vector3d::Unit(axis);
    gradient[axis] = DistanceFrom(solid, point + step) - DistanceFrom(solid, point - step);
  }
  return gradient.normalized();
}

Cloud::Ptr SurfaceOf(const Solid& solid, const std::vector<SurfaceView>& views) {
  Cloud::Ptr surface(new Cloud);
  for (const SurfaceView& view : views) {
    for (const Eigen::Vector3d& point : view.points) {
      pcl::PointNormal entry;
      entry.getVector3fMap() = point.cast<float>();
      entry.getNormalVector3fMap() = NormalAt(solid, point).cast<float>();
      surface->push_back(entry);
    }
  }
  return surface;
}

Cloud::Ptr CloudOf(const std::vector<Eigen::Vector3d>& points) {
  Cloud::Ptr cloud(new Cloud);
  for (const Eigen::Vector3d& point : points) {
    pcl::PointNormal entry;
    entry.getVector3fMap() = point.cast<float>();
    cloud->push_back(entry);
  }
  return cloud;
}

/// Returns the mean distance between the images of `points` under two transforms.
double MeanDistance(const std::vector<Eigen::Vector3d>& points,
                    const Eigen::Isometry3d& a,
                    const Eigen::Isometry3d& b) {
  double sum_m = 0.0;
  for (const Eigen::Vector3d& point : points) sum_m += (a * point - b * point).norm();
  return sum_m / static_cast<double>(points.size());
}

TEST(RegisterPoints, AgreesWithPointToPlaneIcpWhereThatSucceeds) {
  constexpr int kMotionsOfASolid = 100;
  std::mt19937_64 random(1);
  int icp_recovered = 0;
  int both_recovered = 0;
  int ours_recovered = 0;
  for (const Solid& solid : ThingsToLookAt()) {
    const std::vector<SurfaceView> views = LooksAround(solid, kSpacingRad);
    const TsdfGrid volume = MakeVolume(solid, kScale);
    pcl::IterativeClosestPointWithNormals<pcl::PointNormal, pcl::PointNormal> icp;
    icp.setInputTarget(SurfaceOf(solid, views));
    icp.setMaxCorrespondenceDistance(0.3);
    icp.setMaximumIterations(50);
    icp.setTransformationEpsilon(1e-10);
    for (int i = 0; i < kMotionsOfASolid; ++i) {
      const SurfaceView& view = views[static_cast<std::size_t>(i) % views.size()];
      std::vector<Eigen::Vector3d> points = WithNoise(view, 0.003, &random);
      const Eigen::Isometry3d motion = RandomMotionAbout({0.0, 0.0, 0.4}, &random);
      for (Eigen::Vector3d& point : points) point = motion * point;

      icp.setInputSource(CloudOf(points));
      Cloud aligned;
      icp.align(aligned);
      const Eigen::Isometry3d theirs(icp.getFinalTransformation().cast<double>());
      const Eigen::Isometry3d ours =
          RegisterPoints(points, volume, kScale, UprightPose()).T_correction;

      if (MeanDistance(points, ours, motion.inverse()) < kAgreementM) ++ours_recovered;
      if (!icp.hasConverged() || MeanDistance(points, theirs, motion.inverse()) > kAgreementM) {
        continue;
      }
      ++icp_recovered;
      if (MeanDistance(points, ours, theirs) < kAgreementM) ++both_recovered;
    }
  }
  EXPECT_GT(icp_recovered, kMotionsOfASolid) << "too few to compare with";
  EXPECT_GE(both_recovered, icp_recovered * 99 / 100);
  EXPECT_GE(ours_recovered, icp_recovered);
  RecordProperty("icp_recovered", icp_recovered);
  RecordProperty("both_recovered", both_recovered);
  RecordProperty("ours_recovered", ours_recovered);
}

}  // namespace
}  // namespace steadymap
