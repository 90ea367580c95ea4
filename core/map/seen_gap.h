#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

namespace steadymap {

/// A place between two surfaces beside each other through which frames of a session have looked.
/// Sums and means over the frames are weighted by the inverse variance of the direction that each
/// frame tells.
struct SeenGap {
  std::array<std::int32_t, 3> cell{};  ///< Index of the voxel of the world.
  std::uint32_t frames = 0;
  double weight = 0.0;
  double width_m = 0.0;                                    ///< Mean.
  Eigen::Vector3d middle_world = Eigen::Vector3d::Zero();  ///< Mean, between both surfaces, metres.
  /// Sum of the horizontal directions of view, or their opposites, each of unit length.
  Eigen::Vector2d view_sum_world = Eigen::Vector2d::Zero();

  friend bool operator==(const SeenGap&, const SeenGap&) = default;
};

}  // namespace steadymap
