#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "core/working/tracked_object.h"
#include "core/working/working_map.h"

namespace steadymap {

/// A point of a surface with its unit normal, world frame, metres.
struct OrientedPoint {
  Eigen::Vector3d position_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal_world = Eigen::Vector3d::UnitZ();
};

/// Returns the surface points of an object, in the order of `ObjectSurface::leaves()`.
std::vector<OrientedPoint> OrientedSurfaceOf(const TrackedObject& object);

/// Returns the points with the given indices.
std::vector<OrientedPoint> PointsAt(std::span<const OrientedPoint> points,
                                    std::span<const std::size_t> indices);

/// Returns the weights of the voxels of the surface points of an object, in the same order: 1 for
/// one measurement from 1 m at normal incidence (`kWeightUnit`).
std::vector<double> SurfaceWeightsOf(const TrackedObject& object);

/// The principal axes of points, world frame, in the columns, the longest first.
struct PrincipalAxes {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  /// Lengths along the axes by the variance of the points, metres: exact for points that are evenly
  /// spread over a box.
  Eigen::Vector3d lengths_m = Eigen::Vector3d::Zero();
  /// From the first point to the last along the axes, metres.
  Eigen::Vector3d extents_m = Eigen::Vector3d::Zero();
};

PrincipalAxes PrincipalAxesOf(std::span<const OrientedPoint> points);

/// Divides points into sets of which no two points are within `reach_m` of each other: Euclidean
/// clusters. Returns indices into `points`, the largest set first, each in increasing order. Points
/// with a nonzero entry in `is_excluded` are in no set. Cost: about 1 us per point.
std::vector<std::vector<std::size_t>> FindConnectedParts(std::span<const OrientedPoint> points,
                                                         const std::vector<char>& is_excluded,
                                                         double reach_m);

/// Returns by how much a surface turns inwards from one point to another: 1 for a right angle, 0 if
/// it is flat or turns outwards.
double InwardTurn(const OrientedPoint& from, const OrientedPoint& to);

/// Extends parts along a surface: `seeds` are points with their part, and every other point gets
/// the part of the seed from which the shortest way in steps of at most `reach_m` leads to it; 0 if
/// there is none. A way is longer by `concave_cost_m` for a right angle that it turns inwards, as
/// from a floor to what stands on it: things meet there (Stein et al., CVPR 2014).
std::vector<std::size_t> SpreadParts(std::span<const OrientedPoint> points,
                                     std::span<const std::pair<std::size_t, std::size_t>> seeds,
                                     double reach_m,
                                     double concave_cost_m = 0.0);

/// When a part of a surface is a large plane, such as a floor or a wall.
struct PlaneParameters {
  double min_area_m2 = 1.5;
  /// Distance of a point from the plane, metres, and cosine between its normal and the plane's.
  double max_distance_m = 0.05;
  double min_cosine = 0.9;
};

/// A connected plane part of a surface.
struct PlanePart {
  Eigen::Vector3d normal_world = Eigen::Vector3d::UnitZ();  ///< Of unit length.
  Eigen::Vector3d center_world = Eigen::Vector3d::Zero();   ///< Metres.
  std::vector<std::size_t> points;                          ///< Indices.
};

/// Finds the plane parts of a surface with enough area. Each point stands for `point_area_m2`;
/// neighbours on a plane are at most `reach_m` apart.
std::vector<PlanePart> FindPlaneParts(std::span<const OrientedPoint> points,
                                      double point_area_m2,
                                      double reach_m,
                                      const PlaneParameters& parameters);

/// Divides the voxels of an object between itself and new objects of the same state: `part_of` has
/// for each of its surface points, in the order of `OrientedSurfaceOf`, the number of its part, and
/// 0 for what stays. A voxel belongs to the part of the nearest surface point, counted in steps
/// between observed voxels. Returns the new objects of the parts 1 to `part_count`.
std::vector<TrackedObject*> DivideVoxels(TrackedObject* object,
                                         std::span<const std::size_t> part_of,
                                         std::size_t part_count,
                                         WorkingMap* map);

}  // namespace steadymap
