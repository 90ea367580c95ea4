#pragma once

// The kernel from depth pixels to surface cells, a part of tsdf_kernel_body.h.

#include "core/integration/kernel_lanes.h"
#include "core/integration/tsdf_kernel.h"

namespace steadymap {
namespace {

/// Returns the depth of one pixel of each of eight cells, `kFarM` if it has no return.
STEADYMAP_INLINE Floats PixelDepth(Words units, const SurfaceInput& input) {
  const Floats depth_m =
      __builtin_convertvector(reinterpret_cast<Integers>(units), Floats) * input.metres_per_unit;
  const Integers valid = (units != 0U) & (units != 65535U);
  return Select(valid, depth_m, Splat(kFarM));
}

/// Computes the mean depth of the pixels near the nearest pixel of each of eight cells. Pixels
/// further behind are excluded, since a mean across a depth edge lies on neither surface.
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
  const Floats sigma_m = nearest * nearest * input.noise.growth_per_m + input.noise.floor_m;
  const Floats limit = nearest + sigma_m * (kSigmas * kDifferenceSigma);
  Floats sum = Splat(0.0F);
  Floats count = Splat(0.0F);
  for (const Floats& pixel : pixels) {
    const Integers agrees = pixel <= limit;
    sum += Select(agrees, pixel, Splat(0.0F));
    count += Select(agrees, Splat(1.0F), Splat(0.0F));
  }
  const Integers seen = nearest < Splat(kFarM);
  Store(Select(seen, count / sum, Splat(0.0F)), inverse_depth);
  Store(Select(seen, count * 0.25F, Splat(0.0F)), support);
}

/// Returns the offset of a row of cells in the padded planes of the output.
STEADYMAP_INLINE int64_t PlaceOfRow(int row, int64_t stride) {
  return (kSurfaceMarginRows + row) * stride + kSurfaceMargin;
}

void ReduceRow(const SurfaceInput& input, int row, float* inverse_depth, float* support) {
  const int64_t cells_wide = input.width_px / 2;
  const uint16_t* upper = input.depth + static_cast<int64_t>(2 * row) * input.width_px;
  const uint16_t* lower = upper + input.width_px;
  int64_t column = 0;
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

// At the silhouette of a curved object, its curvature could be mistaken for a slope, so one-sided
// slopes must be straighter.
constexpr float kOneSidedShare = 0.5F;

// At more than 80 degrees from normal incidence, depth determines the position of a surface poorly.
constexpr float kMinCosine = 0.17F;

// Number of cells over which the depth of a plane is averaged.
constexpr float kPlaneCells = 5.0F;
constexpr float kLineCells = 3.0F;

constexpr float kPixelsPerCell = 4.0F;

// Three standard deviations of a cell that is on no plane must fit this share of the truncation
// distance: no neighbour tells that it is surface.
constexpr float kNoiseShare = 1.0F / 3.0F;

/// Slope of the inverse depth along one axis.
struct Slope {
  Floats per_cell;  ///< 0 if unknown: the surface is assumed to face the camera.
  Integers planar;  ///< True if the surface continues in a plane on both sides.
  Integers known;   ///< True if it does so on one side, or if both neighbours are far behind.
};

/// True if three equally spaced inverse depths lie on a plane. A missing depth is zero.
STEADYMAP_INLINE Integers IsStraight(Floats a, Floats b, Floats c, Floats max_bend) {
  const Floats zero = Splat(0.0F);
  return (a > zero) & (b > zero) & (c > zero) & (Abs(a - 2.0F * b + c) < max_bend);
}

/// `neighbours` contains the inverse depths at two and one reaches before, and one and two reaches
/// after the centre. `sigma` is the standard deviation of an inverse depth.
STEADYMAP_INLINE Slope EstimateSlope(const Floats neighbours[4], Floats centre, Floats sigma) {
  constexpr float kPerCell = 1.0F / static_cast<float>(kSurfaceReach);
  const Floats zero = Splat(0.0F);
  const Floats max_bend = sigma * (kSigmas * kBendSigma);
  const Integers planar = IsStraight(neighbours[1], centre, neighbours[2], max_bend);
  const Floats max_side_bend = max_bend * kOneSidedShare;
  const Integers before = IsStraight(neighbours[0], neighbours[1], centre, max_side_bend);
  const Integers after = IsStraight(centre, neighbours[2], neighbours[3], max_side_bend);
  const Floats one_sided =
      Select(before, centre - neighbours[1], Select(after, neighbours[2] - centre, zero));
  const Floats per_cell =
      Select(planar, (neighbours[2] - neighbours[1]) * (0.5F * kPerCell), one_sided * kPerCell);
  const Floats nearer = centre + max_bend;
  const Integers thin = (neighbours[1] < nearer) & (neighbours[2] < nearer);
  return {per_cell, planar, planar | before | after | thin};
}

/// True if the centre is a flying pixel along one axis: it lies between a nearer and a farther
/// neighbour and on neither.
STEADYMAP_INLINE Integers IsFlying(Floats before, Floats centre, Floats after, Floats sigma) {
  const Floats jump = sigma * (kSigmas * kDifferenceSigma);
  const Floats rise = centre - before;
  const Floats next_rise = after - centre;
  return ((rise > jump) & (next_rise > jump)) | ((rise < -jump) & (next_rise < -jump));
}

/// Fits planes to the cells of a row from `column` on: eight, or all that remain.
STEADYMAP_INLINE void FitCells(const SurfaceInput& input,
                               const SurfaceOutput& output,
                               int row,
                               int column) {
  const int cells_wide = input.width_px / 2;
  const int64_t stride = SurfaceStride(cells_wide);
  const int64_t at = PlaceOfRow(row, stride) + column;
  const float* inverse_depth = output.inverse_depth + at;
  const Floats zero = Splat(0.0F);
  const Floats centre = Load(inverse_depth);
  Floats beside[4];
  Floats above_below[4];
  for (int i = 0; i < 4; ++i) {
    const int reach = (i < 2 ? i - 2 : i - 1) * kSurfaceReach;
    beside[i] = Load(inverse_depth + reach);
    above_below[i] = Load(inverse_depth + reach * stride);
  }
  const Floats sigma = centre * centre * input.noise.floor_m + input.noise.growth_per_m;
  const Slope along_u = EstimateSlope(beside, centre, sigma);
  const Slope along_v = EstimateSlope(above_below, centre, sigma);
  const Integers flying =
      (~along_u.planar &
       IsFlying(Load(inverse_depth - 1), centre, Load(inverse_depth + 1), sigma)) |
      (~along_v.planar &
       IsFlying(Load(inverse_depth - stride), centre, Load(inverse_depth + stride), sigma));

  // On a plane, the mean of the neighbours equals the centre, so their average reduces the noise.
  // The weight is proportional to the number of averaged cells, the inverse of the variance.
  const Floats three = Splat(1.0F / kLineCells);
  const Floats sum_u = beside[1] + beside[2];
  const Floats sum_v = above_below[1] + above_below[2];
  const Floats mean_u = (sum_u + centre) * three;
  const Floats mean_v = (sum_v + centre) * three;
  const Floats mean_all = (sum_u + sum_v + centre) * (1.0F / kPlaneCells);
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
  const Floats cells_averaged =
      Select(along_u.planar & along_v.planar,
             Splat(kPlaneCells),
             Select(along_u.planar | along_v.planar, Splat(kLineCells), Splat(1.0F)));
  const Floats support = Load(output.support + at);
  Floats weight = Min(inverse * inverse, Splat(kMaxLookWeight)) * cosine * support *
                  cells_averaged * (1.0F / kPlaneCells);
  const Floats noise = sigma * kSigmas;
  const Floats band = inverse * inverse * (input.truncation_m * kNoiseShare);
  const Integers is_sure =
      along_u.planar | along_v.planar | (noise * noise <= band * band * (support * kPixelsPerCell));
  // The depth limit applies to cells, not pixels. A limit per pixel would bias the last cells of an
  // oblique surface towards the camera.
  const Integers near = centre * input.max_depth_m >= Splat(1.0F);
  weight = Select(near & is_sure & (cosine > Splat(kMinCosine)), weight, zero);
  const Integers seen = (centre > zero) & ~flying;
  weight = Select(seen, weight, zero);

  Floats columns[kLanes] = {Select(seen, nx * inverse_norm, zero),
                            Select(seen, ny * inverse_norm, zero),
                            Select(seen, nz * inverse_norm, zero),
                            Select(seen, inverse_norm, zero),
                            Select(seen, 1.0F / inverse, zero),
                            weight,
                            zero,
                            zero};
  Transpose(columns);
  const int count = cells_wide - column < kLanes ? cells_wide - column : kLanes;
  const uint32_t known = ToBits(along_u.known & along_v.known & seen);
  uint8_t* has_plane = output.has_plane + static_cast<int64_t>(row) * cells_wide + column;
  for (int lane = 0; lane < count; ++lane) has_plane[lane] = (known >> lane) & 1U;
  memcpy(output.cells + static_cast<int64_t>(row) * cells_wide + column,
         columns,
         static_cast<uint64_t>(count) * sizeof(SurfaceCell));
}

/// Sets the clearance of the cells of a row from `column` on to 0 where a ray beside the cell may
/// end nearer, else to the maximum: eight cells, or all that remain.
STEADYMAP_INLINE void MarkEdges(const SurfaceInput& input,
                                const SurfaceOutput& output,
                                int row,
                                int column) {
  const int cells_wide = input.width_px / 2;
  const int cells_high = input.height_px / 2;
  const int64_t stride = SurfaceStride(cells_wide);
  const float* inverse_depth = output.inverse_depth + PlaceOfRow(row, stride) + column;
  const Floats centre = Load(inverse_depth);
  const Floats sigma = centre * centre * input.noise.floor_m + input.noise.growth_per_m;
  const Floats limit = centre + sigma * (kSigmas * kDifferenceSigma);
  const Floats nearest = Max(Max(Load(inverse_depth - 1), Load(inverse_depth + 1)),
                             Max(Load(inverse_depth - stride), Load(inverse_depth + stride)));
  const uint32_t open = ToBits((centre > Splat(0.0F)) & (nearest < limit));
  const bool is_border_row = row == 0 || row == cells_high - 1;
  const int count = cells_wide - column < kLanes ? cells_wide - column : kLanes;
  uint8_t* clearance = output.clearance + static_cast<int64_t>(row) * cells_wide + column;
  for (int lane = 0; lane < count; ++lane) {
    const int at = column + lane;
    const bool is_open =
        ((open >> lane) & 1U) != 0 && !is_border_row && at > 0 && at < cells_wide - 1;
    clearance[lane] = is_open ? kMaxClearance : 0;
  }
}

STEADYMAP_INLINE uint8_t Nearer(uint8_t clearance, uint8_t neighbour) {
  const auto next = static_cast<uint8_t>(neighbour + 1U);
  return next < clearance ? next : clearance;
}

/// Computes the distance of each cell to the nearest cell marked 0, in cells, the longer of
/// horizontal and vertical distance: one pass downwards and one upwards. The border is marked.
void SpreadEdges(int cells_wide, int cells_high, uint8_t* clearance) {
  for (int row = 1; row < cells_high - 1; ++row) {
    uint8_t* here = clearance + static_cast<int64_t>(row) * cells_wide;
    const uint8_t* above = here - cells_wide;
    for (int column = 1; column < cells_wide - 1; ++column) {
      for (int side = -1; side <= 1; ++side) {
        here[column] = Nearer(here[column], above[column + side]);
      }
    }
    for (int column = 1; column < cells_wide - 1; ++column) {
      here[column] = Nearer(here[column], here[column - 1]);
    }
  }
  for (int row = cells_high - 2; row > 0; --row) {
    uint8_t* here = clearance + static_cast<int64_t>(row) * cells_wide;
    const uint8_t* below = here + cells_wide;
    for (int column = 1; column < cells_wide - 1; ++column) {
      for (int side = -1; side <= 1; ++side) {
        here[column] = Nearer(here[column], below[column + side]);
      }
    }
    for (int column = cells_wide - 2; column > 0; --column) {
      here[column] = Nearer(here[column], here[column + 1]);
    }
  }
}

void ComputeSurface(const SurfaceInput& input, const SurfaceOutput& output) {
  const int cells_wide = input.width_px / 2;
  const int cells_high = input.height_px / 2;
  const int64_t stride = SurfaceStride(cells_wide);
  for (int row = 0; row < cells_high; ++row) {
    const int64_t at = PlaceOfRow(row, stride);
    ReduceRow(input, row, output.inverse_depth + at, output.support + at);
  }
  for (int row = 0; row < cells_high; ++row) {
    for (int column = 0; column < cells_wide; column += kLanes) {
      FitCells(input, output, row, column);
      MarkEdges(input, output, row, column);
    }
  }
  SpreadEdges(cells_wide, cells_high, output.clearance);
}

}  // namespace
}  // namespace steadymap
