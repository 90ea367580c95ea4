#pragma once

#include <cstdint>

#include "core/volume/voxel_leaf.h"

/// The two hot loops of integration, on plain pointers: from a depth image to surface cells, and
/// from surface cells to the voxels of a leaf. Both are compiled for any processor and, on x86-64,
/// for AVX2, with the same operations in the same order and without fused multiply-add. Both
/// variants give the same bits.
namespace steadymap {

/// The plane observed in a block of 2 x 2 pixels, camera frame.
///
/// The signed distance of a point p (camera frame) from it is `offset_m - normal . p`, positive in
/// front of the surface, on the side of the camera.
struct alignas(32) SurfaceCell {
  float normal_x;  ///< Unit normal, pointing away from the camera.
  float normal_y;
  float normal_z;
  float offset_m;       ///< Distance of the plane from the camera centre.
  float depth_m;        ///< Depth of the surface at the centre of the cell.
  float weight;         ///< 1 at 1 m and normal incidence; 0: no surface observed.
  std::uint32_t color;  ///< Red, green, blue in bytes 0 to 2; byte 3 is 255 if known, else 0.
  std::uint32_t owner;  ///< The owner of the surface; initially 0.
};

/// Owner of the cells that belong to no object.
inline constexpr std::uint32_t kBackgroundOwner = 0;

/// Distance between a cell and the cells used for the fit of its plane, in cells. If one side is
/// cut off, the fit uses the cell at twice this distance on the other side.
inline constexpr int kSurfaceReach = 3;

/// Number of zero rows above and below the cells of `SurfaceOutput::inverse_depth`.
inline constexpr int kSurfaceMarginRows = 2 * kSurfaceReach;

/// Standard deviation of a measured depth z: `floor_m + growth_per_m * z^2`.
struct KernelNoise {
  float floor_m;
  float growth_per_m;
};

/// Depths that differ by at most this number of standard deviations of their noise belong to one
/// surface.
inline constexpr float kSigmas = 3.0F;

/// Standard deviations of a difference and of a second difference, in those of one value.
inline constexpr float kDifferenceSigma = 1.414F;
inline constexpr float kBendSigma = 2.449F;

/// A depth image and its camera, the input of `TsdfKernels::compute_surface`.
struct SurfaceInput {
  const std::uint16_t* depth;  ///< Row-major; 0 and 65535 mean no return.
  int width_px;                ///< At least 2.
  int height_px;               ///< At least 2.
  float metres_per_unit;
  float max_depth_m;
  float truncation_m;  ///< Of the map; limits the noise of cells that are on no plane.
  KernelNoise noise;
  /// Intrinsics of the cell grid, at half the resolution of the pixels.
  float fx;
  float fy;
  float cx;
  float cy;
};

/// The output arrays of `TsdfKernels::compute_surface`. A cell grid has `width_px / 2` x
/// `height_px / 2` cells.
struct SurfaceOutput {
  /// Inverse depth of each cell, 1/m, 0 if none. Has a margin of `kSurfaceMarginRows` rows above
  /// and below and `kSurfaceMargin` columns left and right, which must be zero.
  float* inverse_depth;
  /// Share of a cell's pixels that agree on the depth, in [0, 1]. Has the margin of
  /// `inverse_depth`.
  float* support;
  SurfaceCell* cells;  ///< Row-major, without margin.
  /// Number of cells from each cell to the nearest one at whose side a ray ends nearer or is
  /// unknown, at most `kMaxClearance`: the radius of the free space around a ray. Row-major.
  std::uint8_t* clearance;
  /// 1 if the slope of a cell is known along both axes, or its neighbours are far behind, else 0.
  /// Row-major.
  std::uint8_t* has_plane;
};

/// Largest clearance of a cell, in cells.
inline constexpr std::uint8_t kMaxClearance = 64;

/// Number of zero columns on each side of the cells of `SurfaceOutput::inverse_depth`: rows are
/// read in groups of eight.
inline constexpr int kSurfaceMargin = 8;

/// Returns the row length of `SurfaceOutput::inverse_depth` and `support`.
constexpr int SurfaceStride(int cells_wide) { return ((cells_wide + 7) & ~7) + 2 * kSurfaceMargin; }

/// Maximum weight of a measurement: one from less than 0.5 m has the weight of one from 0.5 m.
inline constexpr float kMaxLookWeight = 4.0F;

/// Minimum depth of a projected point.
inline constexpr float kNearM = 0.05F;

/// Maximum length of the truncation band along the ray, in truncation distances. On an oblique
/// surface the band is longer, but there the tangent plane is unreliable and nearer pixels measure
/// these voxels better.
inline constexpr float kMaxRayBand = 2.0F;

/// The inputs of `TsdfKernels::update_leaf` that are equal for all leaves of a frame and volume.
struct LeafKernelFrame {
  const SurfaceCell* cells;
  const std::uint8_t* clearance;  ///< Of each cell, see `SurfaceOutput`.
  int cells_wide;
  int cells_high;
  float fx;  ///< Intrinsics of the cell grid.
  float fy;
  float cx;
  float cy;
  float step_x[3];  ///< From a voxel to its neighbour along x, camera frame, metres.
  float step_y[3];
  float step_z[3];
  float voxel_size_m;
  float truncation_m;
  float distance_step_m;
  KernelNoise noise;
  std::uint32_t owner;  ///< Surface of other owners is not fused.
  bool fuse_color;
  bool clears;  ///< True: rays clear the voxels that they pass through.
};

/// The inputs and outputs of `TsdfKernels::update_leaf` for one leaf.
struct LeafKernelLeaf {
  float origin[3];          ///< Centre of the leaf's lowest voxel, camera frame, metres.
  std::uint32_t* voxels;    ///< See `Voxel::bits`.
  std::uint32_t* color;     ///< Null if colour is not fused.
  std::uint64_t* observed;  ///< The mask of the leaf. The kernel adds the updated voxels.
};

/// A compiled variant of the hot loops.
struct TsdfKernels {
  const char* name;
  void (*compute_surface)(const SurfaceInput& input, const SurfaceOutput& output);
  /// Fuses the surface into a leaf. Returns true if any bit of the leaf changed.
  bool (*update_leaf)(const LeafKernelFrame& frame, const LeafKernelLeaf& leaf);
};

/// Returns the variant for any processor.
const TsdfKernels& BaselineKernels();

/// Returns the variant for AVX2. Defined on x86-64 only; call `FindAvx2Kernels`.
const TsdfKernels& Avx2Kernels();

/// Returns the variant for AVX2; null if the processor has no AVX2.
const TsdfKernels* FindAvx2Kernels();

/// Returns the faster variant supported by the processor.
const TsdfKernels& SelectKernels();

}  // namespace steadymap
