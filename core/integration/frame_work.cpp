#include "core/integration/frame_work.h"

#include <algorithm>
#include <cmath>

#include <absl/strings/str_cat.h>

#include "core/types/error.h"
#include "core/volume/leaf_set.h"

namespace steadymap {
namespace {

// The widest of the strides, in pixels, that leaves are counted with.
constexpr int kWidestStridePx = 4;

/// Counts the leaves that the truncation band of a depth image meets, in the camera's frame.
class BandCount {
 public:
  BandCount(const Frame& frame, const MapConfig& config)
      : frame_(frame),
        leaf_size_m_(static_cast<float>(config.voxel_size_m) * kLeafSide),
        band_leaves_(static_cast<float>(config.truncation_m) / leaf_size_m_),
        max_depth_m_(static_cast<float>(config.max_depth_m)) {}

  /// The leaves that the rays of every `stride_px`-th pixel of every such row meet; no further than
  /// past `limit`.
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
    // Each ray that is left out meets as many new leaves as one that is not, at most.
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
                      absl::StrCat("what the depth image shows meets more than ",
                                   kMaxFrameLeaves,
                                   " blocks of 8 x 8 x 8 voxels: make the map with voxels larger "
                                   "than ",
                                   config.voxel_size_m,
                                   " m or a max_depth_m below ",
                                   config.max_depth_m));
}

}  // namespace steadymap
