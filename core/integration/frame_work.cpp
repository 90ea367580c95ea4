#include "core/integration/frame_work.h"

#include <algorithm>
#include <cmath>

#include <absl/strings/str_cat.h>

#include "core/types/error.h"
#include "core/volume/leaf_set.h"

namespace steadymap {
namespace {

// The largest pixel stride of the estimate.
constexpr int kWidestStridePx = 4;

/// Counts the leaves in the truncation band of a depth image, in the camera frame.
class BandCount {
 public:
  BandCount(const Frame& frame, const MapConfig& config)
      : frame_(frame),
        leaf_size_m_(static_cast<float>(config.voxel_size_m) * kLeafSide),
        band_leaves_(static_cast<float>(config.truncation_m) / leaf_size_m_),
        max_depth_m_(static_cast<float>(config.max_depth_m)) {}

  /// Returns the number of leaves on the rays of a grid of pixels with `stride_px` spacing. Stops
  /// after a row in which the count exceeds `limit`.
  std::size_t Count(int stride_px, std::size_t limit) {
    leaves_.Reset({});
    for (int v = 0; v < frame_.depth.units.height_px(); v += stride_px) {
      leaves_.StartRow();
      for (int u = 0; u < frame_.depth.units.width_px(); u += stride_px) Insert(u, v);
      if (leaves_.size() > limit) break;
    }
    return leaves_.size();
  }

 private:
  void Insert(int u, int v) {
    const std::uint16_t units = frame_.depth.units.At(u, v);
    if (units == kNoDepth || units == kInvalidDepth) return;
    const float depth_m =
        static_cast<float>(units) * static_cast<float>(frame_.depth.metres_per_unit);
    if (depth_m > max_depth_m_) return;
    const Eigen::Vector3f ray(static_cast<float>((u - frame_.camera.cx) / frame_.camera.fx),
                              static_cast<float>((v - frame_.camera.cy) / frame_.camera.fy),
                              1.0F);
    const float depth_leaves = depth_m / leaf_size_m_;
    leaves_.InsertSegment(ray * std::max(depth_leaves - band_leaves_, 0.0F),
                          ray * (depth_leaves + band_leaves_));
  }

  const Frame& frame_;
  const float leaf_size_m_;
  const float band_leaves_;
  const float max_depth_m_;
  LeafSet leaves_;
};

}  // namespace

std::size_t EstimateTouchedLeaves(const Frame& frame, const MapConfig& config, std::size_t limit) {
  BandCount band(frame, config);
  for (int stride_px = kWidestStridePx; stride_px > 1; stride_px /= 2) {
    // The rays between two counted rays add at most as many leaves each as a counted ray.
    const auto rays = static_cast<std::size_t>(stride_px) * static_cast<std::size_t>(stride_px);
    const std::size_t counted = band.Count(stride_px, limit / rays);
    if (counted * rays <= limit) return counted;
  }
  return band.Count(1, limit);
}

absl::Status CheckFrameWork(const Frame& frame, const MapConfig& config) {
  if (EstimateTouchedLeaves(frame, config, kMaxFrameLeaves) <= kMaxFrameLeaves) {
    return absl::OkStatus();
  }
  return InvalidField(reason::kFrameTooFine,
                      "depth",
                      absl::StrCat("the surface in the depth image touches more than ",
                                   kMaxFrameLeaves,
                                   " blocks of 8 x 8 x 8 voxels: create the map with voxel_size_m "
                                   "above ",
                                   config.voxel_size_m,
                                   " or max_depth_m below ",
                                   config.max_depth_m));
}

}  // namespace steadymap
