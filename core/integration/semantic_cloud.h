#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include "core/frame/depth_sensor.h"
#include "core/frame/frame.h"
#include "core/geometry/geometry.h"
#include "core/integration/tsdf_kernel.h"
#include "core/types/map_config.h"

namespace steadymap {

/// Returns a noise as the kernels take it.
inline KernelNoise ForKernel(const DepthNoise& noise) {
  return {static_cast<float>(noise.floor_m), static_cast<float>(noise.growth_per_m)};
}

/// The semantic cloud of a frame: for each 2 x 2 pixels a cell with the plane observed there, its
/// weight as evidence, class and colour. Cells at depth edges have a low or zero weight. Cells
/// beyond the maximum depth have weight zero.
///
/// Reuses its memory between frames. One thread at a time.
class SemanticCloud {
 public:
  /// Cells of dynamic classes have weight zero, and so have all cells of instances with a majority
  /// of such cells.
  explicit SemanticCloud(const MapConfig& config);

  /// Computes the cloud of a frame that passed `ValidateFrame`. Every cell gets owner 0.
  void Compute(const Frame& frame);

  /// Moves the cloud to a corrected pose of the camera.
  void SetPose(const Eigen::Isometry3d& T_world_camera) { T_world_camera_ = T_world_camera; }

  int cells_wide() const { return cells_wide_; }

  int cells_high() const { return cells_high_; }

  /// Returns the camera of the cell grid: its pixels are the cells.
  const PinholeCamera& camera() const { return cell_camera_; }

  const Eigen::Isometry3d& T_world_camera() const { return T_world_camera_; }

  /// Returns the noise of the frame: that of its kind of sensor, more if its depth shows more.
  const DepthNoise& depth_noise() const { return depth_noise_; }

  /// Returns the standard deviation of the depth of a cell, metres: the mean of four pixels.
  double CellSigmaM(double depth_m) const { return 0.5 * depth_noise_.SigmaM(depth_m); }

  bool has_color() const { return has_color_; }

  /// Returns the cells, row-major.
  const std::vector<SurfaceCell>& cells() const { return cells_; }

  /// True if the plane of a cell follows from its neighbours; see `SurfaceOutput`. Other cells, at
  /// edges, are fused with a plane that faces the camera.
  bool HasPlaneAt(int column, int row) const { return has_plane_[Index(column, row)] != 0; }

  /// Returns the clearance of each cell, row-major; see `SurfaceOutput`.
  const std::vector<std::uint8_t>& clearance() const { return clearance_; }

  const SurfaceCell& At(int column, int row) const { return cells_[Index(column, row)]; }

  /// Returns a cell for the assignment of its owner or weight.
  SurfaceCell& MutableAt(int column, int row) { return cells_[Index(column, row)]; }

  /// Returns the class of a cell, the class of its upper left pixel; 0 in a frame without labels.
  std::uint16_t LabelAt(int column, int row) const {
    return labels_.empty() ? std::uint16_t{0} : labels_[Index(column, row)];
  }

  /// True if the class of the cell is dynamic.
  bool IsDynamicAt(int column, int row) const {
    return any_dynamic_ && !labels_.empty() && is_dynamic_[LabelAt(column, row)] != 0;
  }

  /// Returns the instance of a cell, the instance of its upper left pixel; 0 if none, or in a frame
  /// without instances.
  std::uint16_t InstanceAt(int column, int row) const {
    return instances_.empty() ? std::uint16_t{0} : instances_[Index(column, row)];
  }

  bool has_instances() const { return !instances_.empty(); }

 private:
  std::size_t Index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(cells_wide_) +
           static_cast<std::size_t>(column);
  }

  void ComputeSurface(const Frame& frame);
  void DropDynamicClasses(const Frame& frame);
  void DropDynamicInstances();
  void AddColors(const Frame& frame);
  void TakeCorners(const Image<std::uint16_t>& image, std::vector<std::uint16_t>* corners) const;

  const TsdfKernels& kernels_ = SelectKernels();
  float max_depth_m_;
  float truncation_m_;
  std::vector<std::uint8_t> is_dynamic_;  ///< By class.
  bool any_dynamic_ = false;

  int cells_wide_ = 0;
  int cells_high_ = 0;
  PinholeCamera cell_camera_;
  Eigen::Isometry3d T_world_camera_ = Eigen::Isometry3d::Identity();
  DepthNoise depth_noise_;
  bool has_color_ = false;
  std::vector<float> inverse_depth_;
  std::vector<float> support_;
  std::vector<SurfaceCell> cells_;
  std::vector<std::uint8_t> clearance_;
  std::vector<std::uint8_t> has_plane_;
  std::vector<std::uint16_t> labels_;
  std::vector<std::uint16_t> instances_;
};

}  // namespace steadymap
