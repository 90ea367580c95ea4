// The body of tsdf_kernel_baseline.cpp and tsdf_kernel_avx2.cpp, compiled once for each instruction
// set. It includes no header with inline functions: one compiled for AVX2 could be the copy that
// the linker keeps for everybody. Arithmetic is written on GCC's vector types, eight lanes at a
// time; on a processor without AVX the compiler splits them in two, and the results stay the same.

#include <stdint.h>
#include <string.h>

#include "core/tsdf_kernel.h"

namespace steadymap {
namespace {

#define STEADYMAP_INLINE inline __attribute__((always_inline))

constexpr int kLanes = 8;
using Floats = float __attribute__((vector_size(32)));
using Integers = int32_t __attribute__((vector_size(32)));
using Words = uint32_t __attribute__((vector_size(32)));

constexpr Floats kLaneIndex = {0.0F, 1.0F, 2.0F, 3.0F, 4.0F, 5.0F, 6.0F, 7.0F};

/// A float beyond every depth, still finite when squared.
constexpr float kFarM = 1e9F;

STEADYMAP_INLINE Floats Splat(float value) { return value - Floats{}; }

STEADYMAP_INLINE Floats Load(const float* from) {
  Floats value;
  memcpy(&value, from, sizeof(value));
  return value;
}

STEADYMAP_INLINE void Store(Floats value, float* to) { memcpy(to, &value, sizeof(value)); }

/// Every lane of `mask` must be all ones or all zeros, as comparisons make them.
STEADYMAP_INLINE Floats Select(Integers mask, Floats yes, Floats no) {
#ifdef __AVX2__
  return __builtin_ia32_blendvps256(no, yes, reinterpret_cast<Floats>(mask));
#else
  return reinterpret_cast<Floats>((mask & reinterpret_cast<Integers>(yes)) |
                                  (~mask & reinterpret_cast<Integers>(no)));
#endif
}

STEADYMAP_INLINE Floats Min(Floats a, Floats b) { return a < b ? a : b; }

STEADYMAP_INLINE Floats Max(Floats a, Floats b) { return a > b ? a : b; }

STEADYMAP_INLINE Floats Abs(Floats value) {
  return reinterpret_cast<Floats>(reinterpret_cast<Words>(value) & 0x7FFFFFFFU);
}

STEADYMAP_INLINE Floats Sqrt(Floats value) {
  for (int lane = 0; lane < kLanes; ++lane) value[lane] = __builtin_sqrtf(value[lane]);
  return value;
}

/// To the nearest whole number, ties to even, for magnitudes below 2^22.
STEADYMAP_INLINE Floats Round(Floats value) {
  constexpr float kMagic = 12582912.0F;  // 1.5 * 2^23: adding it leaves no bits for a fraction.
  return (value + kMagic) - kMagic;
}

/// One bit a lane.
STEADYMAP_INLINE uint32_t ToBits(Integers mask) {
#ifdef __AVX2__
  return static_cast<uint32_t>(__builtin_ia32_movmskps256(reinterpret_cast<Floats>(mask)));
#else
  uint32_t bits = 0;
  for (int lane = 0; lane < kLanes; ++lane) bits |= (mask[lane] != 0 ? 1U : 0U) << lane;
  return bits;
#endif
}

/// Turns eight rows of eight into eight columns.
STEADYMAP_INLINE void Transpose(Floats rows[kLanes]) {
  Floats pairs[kLanes];
  for (int i = 0; i < kLanes; i += 2) {
    pairs[i] = __builtin_shufflevector(rows[i], rows[i + 1], 0, 8, 1, 9, 4, 12, 5, 13);
    pairs[i + 1] = __builtin_shufflevector(rows[i], rows[i + 1], 2, 10, 3, 11, 6, 14, 7, 15);
  }
  Floats quads[kLanes];
  for (int i = 0; i < kLanes; i += 4) {
    quads[i] = __builtin_shufflevector(pairs[i], pairs[i + 2], 0, 1, 8, 9, 4, 5, 12, 13);
    quads[i + 1] = __builtin_shufflevector(pairs[i], pairs[i + 2], 2, 3, 10, 11, 6, 7, 14, 15);
    quads[i + 2] = __builtin_shufflevector(pairs[i + 1], pairs[i + 3], 0, 1, 8, 9, 4, 5, 12, 13);
    quads[i + 3] = __builtin_shufflevector(pairs[i + 1], pairs[i + 3], 2, 3, 10, 11, 6, 7, 14, 15);
  }
  for (int i = 0; i < 4; ++i) {
    rows[i] = __builtin_shufflevector(quads[i], quads[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
    rows[i + 4] = __builtin_shufflevector(quads[i], quads[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
  }
}

// ---------------------------------------------------------------------------------------------
// From depth pixels to cells.

// Pixels of a cell that lie further behind its nearest one than this, in inverse metres, belong to
// something else: 3 cm at 1 m, 27 cm at 3 m.
constexpr float kCellJump = 0.03F;

/// Depth of one pixel of each of eight cells, `kFarM` where there is none.
STEADYMAP_INLINE Floats PixelDepth(Words units, const SurfaceInput& input) {
  const Floats depth_m =
      __builtin_convertvector(reinterpret_cast<Integers>(units), Floats) * input.metres_per_unit;
  const Integers valid = (units != 0U) & (units != 65535U);
  return Select(valid, depth_m, Splat(kFarM));
}

/// Means the pixels of eight cells that lie at the nearest pixel's depth. Nearest, because a mean
/// across a depth edge lies on neither side of it.
STEADYMAP_INLINE void ReduceCells(const uint16_t* upper,
                                  const uint16_t* lower,
                                  const SurfaceInput& input,
                                  float* inverse_depth,
                                  float* support) {
  Words rows[2];
  memcpy(&rows[0], upper, sizeof(Words));
  memcpy(&rows[1], lower, sizeof(Words));
  const Floats pixels[4] = {PixelDepth(rows[0] & 0xFFFFU, input),
                            PixelDepth(rows[0] >> 16, input),
                            PixelDepth(rows[1] & 0xFFFFU, input),
                            PixelDepth(rows[1] >> 16, input)};
  const Floats nearest = Min(Min(pixels[0], pixels[1]), Min(pixels[2], pixels[3]));
  const Floats limit = nearest + nearest * nearest * kCellJump;
  Floats sum = Splat(0.0F);
  Floats count = Splat(0.0F);
  for (const Floats& pixel : pixels) {
    const Integers agrees = pixel <= limit;
    sum += Select(agrees, pixel, Splat(0.0F));
    count += Select(agrees, Splat(1.0F), Splat(0.0F));
  }
  // Cut by cell: cut by pixel, a slanted surface would lose the far pixels of its last cells.
  const Integers seen = nearest <= Splat(input.max_depth_m);
  Store(Select(seen, count / sum, Splat(0.0F)), inverse_depth);
  Store(Select(seen, count * 0.25F, Splat(0.0F)), support);
}

void ReduceRow(const SurfaceInput& input, int row, float* inverse_depth, float* support) {
  const int cells_wide = input.width_px / 2;
  const uint16_t* upper = input.depth + static_cast<int64_t>(2 * row) * input.width_px;
  const uint16_t* lower = upper + input.width_px;
  int column = 0;
  for (; column + kLanes <= cells_wide; column += kLanes) {
    ReduceCells(
        upper + 2 * column, lower + 2 * column, input, inverse_depth + column, support + column);
  }
  if (column < cells_wide) {
    uint16_t tail[2][2 * kLanes] = {};
    const uint64_t bytes = static_cast<uint64_t>(cells_wide - column) * 2 * sizeof(uint16_t);
    memcpy(tail[0], upper + 2 * column, bytes);
    memcpy(tail[1], lower + 2 * column, bytes);
    ReduceCells(tail[0], tail[1], input, inverse_depth + column, support + column);
  }
}

// A plane's inverse depth is linear in pixel coordinates and a range sensor's noise is nearly
// constant in inverse depth, so one threshold tells a plane from an edge at any depth: 2 cm at 1 m,
// 18 cm at 3.
constexpr float kPlanarBend = 0.02F;

// Stricter where only one side is seen: at the rim of a curved thing its bend would pass for a
// slope.
constexpr float kEdgeBend = 0.01F;

// Beyond 80 degrees from face on, depth says little about where a surface is.
constexpr float kMinCosine = 0.17F;

// A cell beside an edge may hold flying pixels, and its slope is known from one side only.
constexpr float kEdgeWeight = 0.25F;

// A thin thing in front of everything around it: nothing tells its slope, it is taken as face on.
constexpr float kThinWeight = 0.1F;

// A look from nearer than half a metre counts like one from there.
constexpr float kMaxLookWeight = 4.0F;

/// Slope of the inverse depth along one axis.
struct Slope {
  Floats per_cell;
  Integers planar;  ///< Whether the surface goes on straight on both sides.
  Floats trust;     ///< Factor of a look's weight.
};

/// Whether three inverse depths in a row lie on a plane. Missing ones are zero.
STEADYMAP_INLINE Integers IsStraight(Floats a, Floats b, Floats c, float max_bend) {
  const Floats zero = Splat(0.0F);
  return (a > zero) & (c > zero) & (Abs(a - 2.0F * b + c) < Splat(max_bend));
}

/// `neighbours` holds the inverse depths two reaches and one before, one and two after the centre.
STEADYMAP_INLINE Slope EstimateSlope(const Floats neighbours[4], Floats centre) {
  constexpr float kPerCell = 1.0F / static_cast<float>(kSurfaceReach);
  const Floats zero = Splat(0.0F);
  const Integers planar = IsStraight(neighbours[1], centre, neighbours[2], kPlanarBend);
  const Integers before =
      IsStraight(neighbours[0], neighbours[1], centre, kEdgeBend) & (neighbours[1] > zero);
  const Integers after =
      IsStraight(centre, neighbours[2], neighbours[3], kEdgeBend) & (neighbours[2] > zero);
  // A neighbour that is nearer by far hides where this surface goes; missing ones count as far.
  const Floats nearer = centre + kPlanarBend;
  const Integers thin = (neighbours[1] < nearer) & (neighbours[2] < nearer);
  const Floats one_sided =
      Select(before, centre - neighbours[1], Select(after, neighbours[2] - centre, zero));
  const Floats per_cell =
      Select(planar, (neighbours[2] - neighbours[1]) * (0.5F * kPerCell), one_sided * kPerCell);
  const Floats trust =
      Select(planar,
             Splat(1.0F),
             Select(before | after, Splat(kEdgeWeight), Select(thin, Splat(kThinWeight), zero)));
  return {per_cell, planar, trust};
}

STEADYMAP_INLINE void FitCells(const SurfaceInput& input,
                               const float* inverse_depth,
                               const float* support,
                               int64_t stride,
                               int column,
                               int row,
                               SurfaceCell* cells,
                               int count) {
  const Floats zero = Splat(0.0F);
  const Floats centre = Load(inverse_depth);
  Floats beside[4];
  Floats above_below[4];
  for (int i = 0; i < 4; ++i) {
    const int reach = (i < 2 ? i - 2 : i - 1) * kSurfaceReach;
    beside[i] = Load(inverse_depth + reach);
    above_below[i] = Load(inverse_depth + reach * stride);
  }
  const Slope along_u = EstimateSlope(beside, centre);
  const Slope along_v = EstimateSlope(above_below, centre);

  // On a plane the neighbours' mean is the centre: they halve the noise.
  const Floats three = Splat(1.0F / 3.0F);
  const Floats sum_u = beside[1] + beside[2];
  const Floats sum_v = above_below[1] + above_below[2];
  const Floats mean_u = (sum_u + centre) * three;
  const Floats mean_v = (sum_v + centre) * three;
  const Floats mean_all = (sum_u + sum_v + centre) * 0.2F;
  const Floats inverse =
      Select(along_u.planar & along_v.planar,
             mean_all,
             Select(along_u.planar, mean_u, Select(along_v.planar, mean_v, centre)));

  const Floats u = (static_cast<float>(column) + kLaneIndex) - input.cx;
  const Floats v = Splat(static_cast<float>(row) - input.cy);
  const Floats nx = along_u.per_cell * input.fx;
  const Floats ny = along_v.per_cell * input.fy;
  const Floats nz = inverse - u * along_u.per_cell - v * along_v.per_cell;
  const Floats inverse_norm = 1.0F / Sqrt(nx * nx + ny * ny + nz * nz);
  const Floats ray_x = u * (1.0F / input.fx);
  const Floats ray_y = v * (1.0F / input.fy);
  const Floats cosine = inverse * inverse_norm / Sqrt(1.0F + ray_x * ray_x + ray_y * ray_y);
  Floats weight = Min(inverse * inverse, Splat(kMaxLookWeight)) * cosine * Load(support) *
                  along_u.trust * along_v.trust;
  weight = Select((centre > zero) & (cosine > Splat(kMinCosine)), weight, zero);

  Floats columns[kLanes] = {nx * inverse_norm,
                            ny * inverse_norm,
                            nz * inverse_norm,
                            inverse_norm,
                            1.0F / inverse,
                            weight,
                            zero,
                            zero};
  Transpose(columns);
  memcpy(cells, columns, static_cast<uint64_t>(count) * sizeof(SurfaceCell));
}

void ComputeSurface(const SurfaceInput& input, const SurfaceOutput& output) {
  const int cells_wide = input.width_px / 2;
  const int cells_high = input.height_px / 2;
  const int64_t stride = SurfaceStride(cells_wide);
  const int64_t first = kSurfaceMarginRows * stride + kSurfaceMargin;
  for (int row = 0; row < cells_high; ++row) {
    const int64_t at = first + row * stride;
    ReduceRow(input, row, output.inverse_depth + at, output.support + at);
  }
  for (int row = 0; row < cells_high; ++row) {
    for (int column = 0; column < cells_wide; column += kLanes) {
      const int64_t at = first + row * stride + column;
      const int count = cells_wide - column < kLanes ? cells_wide - column : kLanes;
      FitCells(input,
               output.inverse_depth + at,
               output.support + at,
               stride,
               column,
               row,
               output.cells + static_cast<int64_t>(row) * cells_wide + column,
               count);
    }
  }
}

// ---------------------------------------------------------------------------------------------
// From cells to voxels.

// Nearer than this to the camera's plane nothing is projected.
constexpr float kNearM = 0.05F;

// On a surface seen at a slant, the truncation band is long along the ray. Beyond this many
// truncations the tangent plane is no longer to be trusted; nearer pixels see those voxels better.
constexpr float kMaxRayBand = 2.0F;

// How fast trust falls with the square of the voxels that the surface was seen aside. The floor
// must stay: a low camera sees it from three metres off, six voxels aside.
constexpr float kStraying = 0.5F;

// An old place must still be able to change: evidence is capped.
constexpr float kMaxWeight = 63.0F;

// Settled voxels stay put (decisions.md 2): after this many looks as good as the one at hand, an
// innovation within the dead band is noise. The band grows with depth as the sensor's noise does.
constexpr float kSettledLooks = 32.0F;
constexpr float kDeadBandVoxels = 0.1F;
constexpr float kDeadBandPerSquareMetre = 0.005F;

// Colour is taken where interpolation can reach it.
constexpr float kColorBandVoxels = 1.75F;
constexpr uint32_t kMaxColorLooks = 32;
constexpr int kColorDeadBand = 16;

constexpr float kWeightsPerUnit = 1.0F / kWeightUnit;

/// Moves the mean of `old_color` (with its looks) towards `seen`.
STEADYMAP_INLINE uint32_t FuseColor(uint32_t old_color, uint32_t seen) {
  const uint32_t looks = old_color >> 24;
  const bool settled = looks >= kMaxColorLooks;
  const auto divisor = static_cast<int>(settled ? looks : looks + 1);
  uint32_t fused = static_cast<uint32_t>(divisor) << 24;
  bool moved = !settled;
  for (int shift = 0; shift < 24; shift += 8) {
    const auto mean = static_cast<int>((old_color >> shift) & 0xFFU);
    const int innovation = static_cast<int>((seen >> shift) & 0xFFU) - mean;
    const int half = innovation < 0 ? -divisor / 2 : divisor / 2;
    fused |= static_cast<uint32_t>(mean + (innovation + half) / divisor) << shift;
    moved = moved || innovation > kColorDeadBand || innovation < -kColorDeadBand;
  }
  return moved ? fused : old_color;
}

/// What the loop over a leaf's rows keeps in registers: a copy, which stores to voxels cannot
/// alias.
struct RowConstants {
  explicit STEADYMAP_INLINE RowConstants(const LeafKernelFrame& frame)
      : cells(frame.cells),
        cells_wide(frame.cells_wide),
        fx(frame.fx),
        fy(frame.fy),
        image_x(frame.cx + 0.5F),
        image_y(frame.cy + 0.5F),
        image_width(static_cast<float>(frame.cells_wide)),
        image_height(static_cast<float>(frame.cells_high)),
        along_x(kLaneIndex * frame.step_z[0]),
        along_y(kLaneIndex * frame.step_z[1]),
        along_z(kLaneIndex * frame.step_z[2]),
        truncation_m(frame.truncation_m),
        fade_from_m(-frame.voxel_size_m),
        fade_scale(1.0F / (frame.truncation_m - frame.voxel_size_m)),
        inverse_voxel_size2(1.0F / (frame.voxel_size_m * frame.voxel_size_m)),
        dead_band_m(kDeadBandVoxels * frame.voxel_size_m),
        color_band_m(kColorBandVoxels * frame.voxel_size_m),
        distance_step_m(frame.distance_step_m),
        steps_per_m(1.0F / frame.distance_step_m) {}

  const SurfaceCell* cells;
  int32_t cells_wide;
  float fx;
  float fy;
  float image_x;  ///< Principal point, shifted so that truncation finds the nearest cell.
  float image_y;
  float image_width;
  float image_height;
  Floats along_x;  ///< From a row's first voxel to each of its voxels, camera frame.
  Floats along_y;
  Floats along_z;
  float truncation_m;
  float fade_from_m;
  float fade_scale;
  float inverse_voxel_size2;
  float dead_band_m;
  float color_band_m;
  float distance_step_m;
  float steps_per_m;
};

/// What the frame says about eight voxels of a row.
struct RowEvidence {
  Floats distance_m;
  Floats weight;
  Floats depth_m;  ///< Of the voxels.
  Integers valid;
  int32_t cell[kLanes];
};

/// The first or second half of eight cells, as four columns.
STEADYMAP_INLINE void LoadHalfCells(const SurfaceCell* cells,
                                    const int32_t index[kLanes],
                                    int half,
                                    Floats columns[4]) {
  using Quad = float __attribute__((vector_size(16)));
  Quad quads[kLanes];
  for (int lane = 0; lane < kLanes; ++lane) {
    const char* cell = reinterpret_cast<const char*>(cells + index[lane]);
    memcpy(&quads[lane], cell + half * static_cast<int>(sizeof(Quad)), sizeof(Quad));
  }
  Floats rows[4];
  for (int i = 0; i < 4; ++i) {
    rows[i] = __builtin_shufflevector(quads[i], quads[i + 4], 0, 1, 2, 3, 4, 5, 6, 7);
  }
  const Floats low01 = __builtin_shufflevector(rows[0], rows[1], 0, 8, 1, 9, 4, 12, 5, 13);
  const Floats high01 = __builtin_shufflevector(rows[0], rows[1], 2, 10, 3, 11, 6, 14, 7, 15);
  const Floats low23 = __builtin_shufflevector(rows[2], rows[3], 0, 8, 1, 9, 4, 12, 5, 13);
  const Floats high23 = __builtin_shufflevector(rows[2], rows[3], 2, 10, 3, 11, 6, 14, 7, 15);
  columns[0] = __builtin_shufflevector(low01, low23, 0, 1, 8, 9, 4, 5, 12, 13);
  columns[1] = __builtin_shufflevector(low01, low23, 2, 3, 10, 11, 6, 7, 14, 15);
  columns[2] = __builtin_shufflevector(high01, high23, 0, 1, 8, 9, 4, 5, 12, 13);
  columns[3] = __builtin_shufflevector(high01, high23, 2, 3, 10, 11, 6, 7, 14, 15);
}

/// Looks up the surface at eight voxels; false if none of them lies in a truncation band.
STEADYMAP_INLINE bool GatherEvidence(const RowConstants& constants,
                                     const float base[3],
                                     RowEvidence* evidence) {
  const Floats x = base[0] + constants.along_x;
  const Floats y = base[1] + constants.along_y;
  const Floats z = base[2] + constants.along_z;
  const Floats inverse_z = 1.0F / z;
  const Floats zero = Splat(0.0F);
  const Floats u = constants.fx * x * inverse_z + constants.image_x;
  const Floats v = constants.fy * y * inverse_z + constants.image_y;
  const Integers in_image = (z > Splat(kNearM)) & (u >= zero) & (v >= zero) &
                            (u < Splat(constants.image_width)) &
                            (v < Splat(constants.image_height));
  if (ToBits(in_image) == 0) return false;

  const Integers column = __builtin_convertvector(Select(in_image, u, zero), Integers);
  const Integers row = __builtin_convertvector(Select(in_image, v, zero), Integers);
  const Integers cell = row * constants.cells_wide + column;
  memcpy(evidence->cell, &cell, sizeof(cell));
  Floats plane[4];
  LoadHalfCells(constants.cells, evidence->cell, 0, plane);
  const Floats distance_m = plane[3] - (plane[0] * x + plane[1] * y + plane[2] * z);
  const Integers in_band = in_image & (Abs(distance_m) < Splat(constants.truncation_m));
  if (ToBits(in_band) == 0) return false;

  Floats look[4];
  LoadHalfCells(constants.cells, evidence->cell, 1, look);
  // Behind the surface nothing was seen: trust fades from one voxel to the end of the band.
  const Floats fade = Select(distance_m < Splat(constants.fade_from_m),
                             (constants.truncation_m + distance_m) * constants.fade_scale,
                             Splat(1.0F));
  // Along a slanted ray the surface was seen beside the voxel's foot on it. The further beside, the
  // more a curved surface has strayed from the tangent plane.
  const Floats along_ray_m = look[0] - z;
  const Floats beside_voxels2 =
      (along_ray_m * along_ray_m - distance_m * distance_m) * constants.inverse_voxel_size2;
  const Floats straying = 1.0F / (1.0F + Max(beside_voxels2, zero) * kStraying);
  evidence->distance_m = distance_m;
  evidence->weight = look[1] * fade * straying;
  evidence->depth_m = z;
  evidence->valid = in_band & (Abs(along_ray_m) < Splat(kMaxRayBand * constants.truncation_m)) &
                    (evidence->weight >= Splat(kWeightUnit));
  return ToBits(evidence->valid) != 0;
}

/// Fuses evidence into eight voxels; one bit a voxel that changed.
STEADYMAP_INLINE uint32_t FuseRow(const RowConstants& constants,
                                  const RowEvidence& evidence,
                                  float* distance_m,
                                  float* weight) {
  const Floats old_distance_m = Load(distance_m);
  const Floats old_weight = Load(weight);
  const Floats dead_band_m =
      Splat(constants.dead_band_m) + evidence.depth_m * evidence.depth_m * kDeadBandPerSquareMetre;
  const Integers settled = (old_weight >= evidence.weight * kSettledLooks) &
                           (Abs(evidence.distance_m - old_distance_m) < dead_band_m);
  const Integers fuse = evidence.valid & ~settled;
  const Floats total = old_weight + evidence.weight;
  const Floats mean_m =
      (old_distance_m * old_weight + evidence.distance_m * evidence.weight) / total;
  const Floats new_distance_m = Round(mean_m * constants.steps_per_m) * constants.distance_step_m;
  const Floats new_weight = Min(Round(total * kWeightsPerUnit) * kWeightUnit, Splat(kMaxWeight));
  Store(Select(fuse, new_distance_m, old_distance_m), distance_m);
  Store(Select(fuse, new_weight, old_weight), weight);
  return ToBits(fuse & ((new_distance_m != old_distance_m) | (new_weight != old_weight)));
}

/// Fuses the colours of eight voxels near the surface; true if any changed.
STEADYMAP_INLINE bool FuseRowColors(const RowConstants& constants,
                                    const RowEvidence& evidence,
                                    uint32_t* color) {
  const Integers near_surface =
      evidence.valid & (Abs(evidence.distance_m) < Splat(constants.color_band_m));
  bool changed = false;
  for (uint32_t bits = ToBits(near_surface); bits != 0; bits &= bits - 1) {
    const int lane = __builtin_ctz(bits);
    const uint32_t seen = constants.cells[evidence.cell[lane]].color;
    if ((seen >> 24) == 0) continue;
    const uint32_t fused = FuseColor(color[lane], seen);
    changed = changed || fused != color[lane];
    color[lane] = fused;
  }
  return changed;
}

bool UpdateLeaf(const LeafKernelFrame& frame, const LeafKernelLeaf& leaf) {
  const RowConstants constants(frame);
  bool changed = false;
  for (int x = 0; x < kLeafSide; ++x) {
    for (int y = 0; y < kLeafSide; ++y) {
      float base[3];
      for (int axis = 0; axis < 3; ++axis) {
        base[axis] = leaf.origin[axis] + static_cast<float>(x) * frame.step_x[axis] +
                     static_cast<float>(y) * frame.step_y[axis];
      }
      RowEvidence evidence;
      if (!GatherEvidence(constants, base, &evidence)) continue;
      const int offset = (x * kLeafSide + y) * kLeafSide;
      const uint32_t moved =
          FuseRow(constants, evidence, leaf.distance_m + offset, leaf.weight + offset);
      changed = changed || moved != 0;
      leaf.observed[x] |= static_cast<uint64_t>(ToBits(evidence.valid)) << (y * kLeafSide);
      if (leaf.color != nullptr) {
        changed = FuseRowColors(constants, evidence, leaf.color + offset) || changed;
      }
    }
  }
  return changed;
}

}  // namespace

const TsdfKernels& STEADYMAP_KERNEL_FUNCTION() {
  static constexpr TsdfKernels kKernels = {STEADYMAP_KERNEL_NAME, ComputeSurface, UpdateLeaf};
  return kKernels;
}

}  // namespace steadymap
