#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "core/frame/frame.h"
#include "core/integration/semantic_cloud.h"

namespace steadymap {

/// One of the surface points that decisions are made with.
struct SurfaceSample {
  Eigen::Vector3f position_world;  ///< Metres.
  Eigen::Vector3f normal_world;    ///< Unit, towards the camera.
  float depth_m = 0.0F;            ///< 0: nothing was seen here, and nothing else holds.
  float area_m2 = 0.0F;            ///< Of the surface that the sample stands for.
  std::uint16_t label = 0;         ///< Class, by majority around the sample.
  std::uint16_t instance = 0;      ///< 0: none.

  bool is_valid() const { return depth_m > 0.0F; }
};

/// Column and row of a sample.
struct SamplePlace {
  int column = 0;
  int row = 0;
};

/// Every second cell of a semantic cloud in both directions, in the world frame.
class SampleGrid {
 public:
  /// Cells from one sample to the next.
  static constexpr int kStrideCells = 2;

  /// Cosine of the largest angle between a ray and the normal of a surface at which the frame still
  /// tells its area and its label; of looks, the parameter `min_facing_cosine`.
  static constexpr float kMinFacingCosine = 0.25F;

  /// Returns the distance of neighbouring samples on surface at a depth of one metre that faces the
  /// camera, metres. `cell_camera` is that of the semantic cloud.
  static double SpacingPerM(const PinholeCamera& cell_camera) {
    return kStrideCells / std::sqrt(cell_camera.fx * cell_camera.fy);
  }

  /// Takes the samples of a frame.
  void Compute(const SemanticCloud& cloud);

  int width() const { return width_; }

  int height() const { return height_; }

  std::size_t size() const { return samples_.size(); }

  const SurfaceSample& operator[](std::size_t index) const { return samples_[index]; }

  std::size_t Index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(column);
  }

  const SurfaceSample& At(int column, int row) const { return samples_[Index(column, row)]; }

  /// Returns the sample on whose `kStrideCells` x `kStrideCells` cells a point of the camera frame
  /// with z > 0 falls; none outside of the image. `cell_camera` is that of the semantic cloud.
  std::optional<SamplePlace> FindPlace(const PinholeCamera& cell_camera,
                                       const Eigen::Vector3f& point_camera) const {
    const Eigen::Vector2f corner = cell_camera.Project(point_camera) + Eigen::Vector2f(0.5F, 0.5F);
    const Eigen::Vector2f end(static_cast<float>(width_ * kStrideCells),
                              static_cast<float>(height_ * kStrideCells));
    if (!((corner.array() >= 0.0F) && (corner.array() < end.array())).all()) return std::nullopt;
    return SamplePlace{static_cast<int>(corner.x()) / kStrideCells,
                       static_cast<int>(corner.y()) / kStrideCells};
  }

 private:
  int width_ = 0;
  int height_ = 0;
  std::vector<SurfaceSample> samples_;
};

/// Whether one surface goes on from `a` to its neighbour `b` in the grid.
bool AreConnected(const SurfaceSample& a, const SurfaceSample& b);

}  // namespace steadymap
