#pragma once

#include <cstdint>

#include "core/volume/voxel_leaf.h"

/// The two hot loops of integration, on plain pointers: from a depth image to surface cells, and
/// from surface cells to the voxels of a leaf. They exist twice, compiled for AVX2 and for any
/// x86-64, with the same operations in the same order and without fused multiply-add, so both give
/// the same bits.
namespace steadymap {

/// The plane that the depth image shows around one 2 x 2 block of pixels, in the camera frame.
///
/// The signed distance of a camera-frame point p from it is `offset_m - normal . p`: positive in
/// front, on the camera's side.
struct alignas(32) SurfaceCell {
  float normal_x;  ///< Unit, pointing away from the camera.
  float normal_y;
  float normal_z;
  float offset_m;       ///< Distance of the plane from the camera's centre.
  float depth_m;        ///< Depth of the surface at the cell's centre.
  float weight;         ///< Of one look, 1 at 1 m and face on; 0: nothing seen here.
  std::uint32_t color;  ///< Red, green, blue in bytes 0 to 2; byte 3 is 255 if known, else 0.
  std::uint32_t owner;  ///< Whose surface it is; 0 until somebody says otherwise.
};

/// Owner of the cells that belong to no object.
inline constexpr std::uint32_t kBackgroundOwner = 0;

/// Distance from a cell to the cells that its plane is fitted through, in cells; where one side is
/// cut off, twice as far on the other.
inline constexpr int kSurfaceReach = 3;

/// Rows of zeros above and below the cells of `SurfaceOutput::inverse_depth`.
inline constexpr int kSurfaceMarginRows = 2 * kSurfaceReach;

/// A depth image and the camera that took it, for `SurfaceKernel`.
struct SurfaceInput {
  const std::uint16_t* depth;  ///< Row-major; 0 and 65535 mean no return.
  int width_px;                ///< At least 2.
  int height_px;               ///< At least 2.
  float metres_per_unit;
  float max_depth_m;
  /// The pinhole camera of the cells: half the resolution of the pixels.
  float fx;
  float fy;
  float cx;
  float cy;
};

/// Arrays that `SurfaceKernel` fills. A cell grid is `width_px / 2` by `height_px / 2`.
struct SurfaceOutput {
  /// Inverse depth of each cell, 1/m, 0 none, with a margin of `kSurfaceMarginRows` rows above and
  /// below and `kSurfaceMargin` columns left and right that must hold zeros.
  float* inverse_depth;
  /// Share of a cell's pixels that agree, in [0, 1]; as `inverse_depth`.
  float* support;
  SurfaceCell* cells;  ///< Row-major, without margin.
};

/// Columns of zeros beside the cells of `SurfaceOutput::inverse_depth`: rows are read in eights.
inline constexpr int kSurfaceMargin = 8;

/// Row length of `SurfaceOutput::inverse_depth` and `support`.
constexpr int SurfaceStride(int cells_wide) { return ((cells_wide + 7) & ~7) + 2 * kSurfaceMargin; }

/// Nothing nearer than this to the camera's plane is projected.
inline constexpr float kNearM = 0.05F;

/// On a surface seen at a slant the truncation band is long along the ray. Beyond this many
/// truncations the tangent plane is not to be trusted; nearer pixels see those voxels better.
inline constexpr float kMaxRayBand = 2.0F;

/// The frame's side of `LeafKernel`, the same for all leaves.
struct LeafKernelFrame {
  const SurfaceCell* cells;
  int cells_wide;
  int cells_high;
  float fx;  ///< Camera of the cells.
  float fy;
  float cx;
  float cy;
  float step_x[3];  ///< From a voxel to its neighbour along x, camera frame, metres.
  float step_y[3];
  float step_z[3];
  float voxel_size_m;
  float truncation_m;
  float distance_step_m;
  std::uint32_t owner;  ///< Cells of other owners are left out.
  bool fuse_color;
};

/// The leaf's side of `LeafKernel`.
struct LeafKernelLeaf {
  float origin[3];  ///< Centre of the leaf's lowest voxel, camera frame, metres.
  float* distance_m;
  float* weight;
  std::uint32_t* color;     ///< Null if colour is not fused.
  std::uint64_t* observed;  ///< The leaf's mask, extended by the voxels that are updated.
};

/// The compiled variants of the hot loops.
struct TsdfKernels {
  const char* name;
  void (*compute_surface)(const SurfaceInput& input, const SurfaceOutput& output);
  /// Fuses the surface into a leaf; true if any bit of it changed.
  bool (*update_leaf)(const LeafKernelFrame& frame, const LeafKernelLeaf& leaf);
};

/// For any x86-64.
const TsdfKernels& BaselineKernels();

/// For processors with AVX2.
const TsdfKernels& Avx2Kernels();

/// The best of the two that this processor runs.
const TsdfKernels& SelectKernels();

}  // namespace steadymap
