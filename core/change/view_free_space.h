#pragma once

#include <Eigen/Geometry>

#include "core/change/min_depth_grid.h"
#include "core/integration/semantic_cloud.h"

namespace steadymap {

/// Returns how far behind a surface at `depth_m` the measured depth must be for the surface to be
/// gone, metres: more than noise and pose error, less than a shift of a decimetre.
inline float SeenThroughMargin(float depth_m) { return 0.05F + 0.007F * depth_m * depth_m; }

/// The space that one frame looks through, whatever the classes of what it sees: up to the nearest
/// raw depth around, and no further than a limit.
class ViewFreeSpace {
 public:
  /// `cloud` and `tiles` are of the same frame and must outlive the view. `max_depth_m`: as far as
  /// depth is trusted.
  ViewFreeSpace(const SemanticCloud& cloud, const MinDepthGrid& tiles, double max_depth_m);

  /// Whether the frame looks through a point and on for `margin_m` at least.
  bool LooksThrough(const Eigen::Vector3f& point_world, float margin_m) const;

  /// Whether a point lies in free space with nothing that the frame sees nearer than
  /// `clearance_m`, as far as the frame tells.
  bool IsClear(const Eigen::Vector3f& point_world, float clearance_m) const;

  /// Depth of a point, metres; negative behind the camera.
  float DepthOf(const Eigen::Vector3f& point_world) const {
    return (T_camera_world_ * point_world).z();
  }

  /// The camera's centre, metres.
  const Eigen::Vector3f& camera_world() const { return camera_world_; }

  int columns() const { return columns_; }

  int rows() const { return rows_; }

  /// Where the ray through the middle of a tile ends: at the nearest depth around or the limit;
  /// the camera itself where nothing was measured.
  Eigen::Vector3f EndOfRay(int column, int row) const;

 private:
  /// Where a point appears.
  struct Sight {
    bool is_in_view = false;
    int column = 0;
    int row = 0;
    Eigen::Vector3f point_camera = Eigen::Vector3f::Zero();
  };

  Sight Look(const Eigen::Vector3f& point_world) const;

  const SemanticCloud& cloud_;
  const MinDepthGrid& tiles_;
  int columns_;
  int rows_;
  float max_depth_m_;
  Eigen::Isometry3f T_camera_world_;
  Eigen::Matrix3f rotation_world_camera_;
  Eigen::Vector3f camera_world_;
};

}  // namespace steadymap
