#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "core/association/gaps.h"
#include "core/map/seen_gap.h"
#include "core/objects/surface_parts.h"

/// The gaps between things beside each other. Only frames that look along a narrow gap show it;
/// most look at it from the side, see one surface, and fuse it into one. So the gaps are kept as
/// places, and divide at the end of the session what was fused across them.
namespace steadymap {

/// Adds the gaps that a frame looks through to those of its session, which are in the order of
/// their cells.
void AddGaps(std::span<const GapInView> gaps, double voxel_size_m, std::vector<SeenGap>* into);

/// Adds gaps to others. Both are in the order of their cells.
void MergeGaps(std::span<const SeenGap> added, std::vector<SeenGap>* into);

/// A gap between two things: a vertical plane.
struct GapPlane {
  Eigen::Vector3d center_world = Eigen::Vector3d::Zero();   ///< Metres.
  Eigen::Vector3d normal_world = Eigen::Vector3d::UnitX();  ///< Horizontal.
  double width_m = 0.0;
  std::vector<Eigen::Vector3d> seen_world;  ///< Where frames have looked through it, metres.

  /// Returns the distance of a point from the plane, metres; negative on one side.
  double DistanceOf(const Eigen::Vector3d& point_world) const {
    return normal_world.dot(point_world - center_world);
  }
};

/// Which places are of one gap.
struct GapPlaneParameters {
  /// Fewer frames may have a wrong pose or depth.
  std::uint64_t min_frames = 2;
  /// Places of one gap are on one plane to a voxel, and each is closer to another one, metres:
  /// frames look into it from above, and from two sides.
  double reach_m = 0.3;
  /// Largest angle between the directions of two places of one gap, as a cosine.
  double min_cosine = 0.85;

  friend bool operator==(const GapPlaneParameters&, const GapPlaneParameters&) = default;
};

/// Finds the gaps that enough frames have looked through, those seen at most places first.
std::vector<GapPlane> FindGapPlanes(const GapPlaneParameters& parameters,
                                    std::span<const SeenGap> gaps,
                                    double voxel_size_m);

/// True if a gap divides a surface that has points at both edges of it: the gap was looked through
/// at more places of its plane, squares of a voxel, than surface crosses it at, and from top to
/// bottom.
bool Divides(const GapPlane& gap, std::span<const OrientedPoint> points, double voxel_size_m);

/// True if a surface has points at an edge of a gap.
bool IsBeside(const GapPlane& gap, std::span<const OrientedPoint> points, double voxel_size_m);

}  // namespace steadymap
