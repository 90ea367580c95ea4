#include "core/registration/icp.h"

#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Eigenvalues>
#include <pcl/console/print.h>
#include <pcl/point_types.h>
#include <pcl/registration/icp.h>
#include <pcl/registration/transformation_estimation_point_to_plane_lls.h>

namespace steadymap {
namespace {

using IcpPoints = pcl::PointCloud<pcl::PointNormal>;

// Four unknowns plus a margin.
constexpr std::size_t kMinIcpPoints = 10;

// A direction with less than this share of the normals of the pairs is not corrected: noise in the
// normals can have this share.
constexpr double kMinIcpDirectionShare = 0.015;

// Squared length of the last step, square metres: 1 mm.
constexpr double kIcpTransformationEpsilon = 1e-6;

using PointToPlane =
    pcl::registration::TransformationEstimationPointToPlaneLLS<pcl::PointNormal, pcl::PointNormal>;

/// Estimates the motion (translation and yaw) that minimises the distances of points from their
/// paired planes. PCL's own estimator has six degrees of freedom, and its result is not finite if
/// the planes leave some of them undetermined.
class UprightPointToPlane final : public PointToPlane {
 public:
  using PointToPlane::estimateRigidTransformation;

  void estimateRigidTransformation(const IcpPoints& source,
                                   const IcpPoints& target,
                                   const pcl::Correspondences& pairs,
                                   Matrix4& transformation) const override {
    transformation.setIdentity();
    if (pairs.empty()) return;
    const auto count = static_cast<double>(pairs.size());
    Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
    for (const pcl::Correspondence& pair : pairs) centroid += PositionOf(source, pair.index_query);
    centroid /= count;
    double square_lever_m2 = 1e-6;
    for (const pcl::Correspondence& pair : pairs) {
      const Eigen::Vector3d arm = PositionOf(source, pair.index_query) - centroid;
      square_lever_m2 += arm.head<2>().squaredNorm() / count;
    }
    // The rotation is scaled by the lever, so that all four unknowns are metres.
    const double lever_m = std::sqrt(square_lever_m2);

    Eigen::Matrix4d information = Eigen::Matrix4d::Zero();
    Eigen::Vector4d gradient = Eigen::Vector4d::Zero();
    for (const pcl::Correspondence& pair : pairs) {
      const Eigen::Vector3d point = PositionOf(source, pair.index_query);
      const pcl::PointNormal& plane = target[static_cast<std::size_t>(pair.index_match)];
      const Eigen::Vector3d normal = plane.getNormalVector3fMap().cast<double>();
      const Eigen::Vector3d arm = point - centroid;
      Eigen::Vector4d row;
      row << normal, (arm.x() * normal.y() - arm.y() * normal.x()) / lever_m;
      information += row * row.transpose() / count;
      gradient += row * normal.dot(point - plane.getVector3fMap().cast<double>()) / count;
    }
    const Eigen::Vector4d step = -Solve(information, gradient);
    const Eigen::Isometry3d motion =
        Eigen::Translation3d(centroid + step.head<3>()) *
        Eigen::AngleAxisd(step[3] / lever_m, Eigen::Vector3d::UnitZ()) *
        Eigen::Translation3d(-centroid);
    transformation = motion.matrix().cast<float>();
  }

 private:
  static Eigen::Vector3d PositionOf(const IcpPoints& points, pcl::index_t index) {
    return points[static_cast<std::size_t>(index)].getVector3fMap().cast<double>();
  }

  /// Returns the minimum-norm solution along the directions that the pairs determine.
  static Eigen::Vector4d Solve(const Eigen::Matrix4d& information, const Eigen::Vector4d& right) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> eigen(information);
    Eigen::Vector4d solution = Eigen::Vector4d::Zero();
    for (int i = 0; i < 4; ++i) {
      if (!(eigen.eigenvalues()[i] > kMinIcpDirectionShare)) continue;
      const Eigen::Vector4d direction = eigen.eigenvectors().col(i);
      solution += direction.dot(right) / eigen.eigenvalues()[i] * direction;
    }
    return solution;
  }
};

/// Suppresses PCL's message about points too far away for a pair, which is not an error here. Only
/// once, since the verbosity level is a global that threads of other maps read.
void Silence() {
  [[maybe_unused]] static const bool is_silent = [] {
    pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
    return true;
  }();
}

/// PCL uses single precision, which is sufficient near `origin_world`.
IcpPoints::Ptr CloudOfSurface(const TrackedObject& object, const Eigen::Vector3d& origin_world) {
  IcpPoints::Ptr cloud(new IcpPoints);
  const Eigen::Isometry3d T_world_object = object.state().T_world_object.ToIsometry();
  for (const SurfaceLeaf& leaf : object.surface().leaves()) {
    for (const SurfaceVoxel& voxel : leaf.points) {
      pcl::PointNormal point;
      point.getVector3fMap() =
          (T_world_object * voxel.position_object.cast<double>() - origin_world).cast<float>();
      point.getNormalVector3fMap() =
          (T_world_object.linear() * voxel.normal_object.cast<double>()).cast<float>();
      cloud->push_back(point);
    }
  }
  return cloud;
}

/// Returns at most `wanted` points, evenly selected.
IcpPoints::Ptr CloudOfPoints(std::span<const Eigen::Vector3d> points_world,
                             const Eigen::Vector3d& origin_world,
                             std::size_t wanted) {
  IcpPoints::Ptr cloud(new IcpPoints);
  const std::size_t step = (points_world.size() + wanted - 1) / wanted;
  for (std::size_t i = 0; i < points_world.size(); i += step) {
    if (!points_world[i].allFinite()) continue;
    pcl::PointNormal point;
    point.getVector3fMap() = (points_world[i] - origin_world).cast<float>();
    cloud->push_back(point);
  }
  return cloud;
}

}  // namespace

class IcpTarget::Implementation {
 public:
  Implementation(const TrackedObject& object, const IcpParameters& parameters)
      : parameters_(parameters), origin_world_(object.state().T_world_object.position_world) {
    Silence();
    const IcpPoints::Ptr surface = CloudOfSurface(object, origin_world_);
    size_ = surface->size();
    if (size_ < kMinIcpPoints) return;
    icp_.setInputTarget(surface);
    icp_.setTransformationEstimation(std::make_shared<UprightPointToPlane>());
    icp_.setMaxCorrespondenceDistance(parameters.max_pair_distance_m);
    icp_.setMaximumIterations(parameters.max_iterations);
    icp_.setTransformationEpsilon(kIcpTransformationEpsilon);
  }

  IcpFit Align(std::span<const Eigen::Vector3d> points_world) {
    IcpFit fit;
    const IcpPoints::Ptr points =
        CloudOfPoints(points_world, origin_world_, parameters_.max_points);
    if (size_ < kMinIcpPoints || points->size() < kMinIcpPoints) return fit;
    icp_.setInputSource(points);
    IcpPoints aligned;
    icp_.align(aligned);
    const Eigen::Matrix4d found = icp_.getFinalTransformation().cast<double>();
    if (!icp_.hasConverged() || !found.allFinite()) return fit;

    const Eigen::Isometry3d T_near_origin(found);
    fit.T_correction =
        Eigen::Translation3d(origin_world_) * T_near_origin * Eigen::Translation3d(-origin_world_);
    fit.yaw_rad = std::atan2(found(1, 0), found(0, 0));
    std::size_t outliers = 0;
    for (std::size_t i = 0; i < points->size(); ++i) {
      fit.shift_world +=
          (aligned[i].getVector3fMap() - (*points)[i].getVector3fMap()).cast<double>();
      if (SquaredDistanceTo(aligned[i]) >
          parameters_.outlier_distance_m * parameters_.outlier_distance_m) {
        ++outliers;
      }
    }
    const auto count = static_cast<double>(points->size());
    fit.shift_world /= count;
    fit.outlier_share = static_cast<double>(outliers) / count;
    return fit;
  }

 private:
  double SquaredDistanceTo(const pcl::PointNormal& point) {
    pcl::Indices nearest(1);
    std::vector<float> squared_m2(1);
    const bool is_found =
        icp_.getSearchMethodTarget()->nearestKSearch(point, 1, nearest, squared_m2) == 1;
    return is_found ? static_cast<double>(squared_m2[0]) : std::numeric_limits<double>::infinity();
  }

  IcpParameters parameters_;
  Eigen::Vector3d origin_world_;
  std::size_t size_ = 0;  ///< Number of points of the target.
  pcl::IterativeClosestPointWithNormals<pcl::PointNormal, pcl::PointNormal> icp_;
};

IcpTarget::IcpTarget(const TrackedObject& object, const IcpParameters& parameters)
    : implementation_(std::make_unique<Implementation>(object, parameters)) {}

IcpTarget::~IcpTarget() = default;

IcpFit IcpTarget::Align(std::span<const Eigen::Vector3d> points_world) {
  return implementation_->Align(points_world);
}

}  // namespace steadymap
