#pragma once

// The kernel from depth pixels to surface cells, a part of tsdf_kernel_body.h.

#include "core/integration/kernel_lanes.h"
#include "core/integration/tsdf_kernel.h"

namespace steadymap {
namespace {

// Maximum difference from the inverse depth of the cell's nearest pixel, 1/m. Pixels further behind
// belong to another surface: 3 cm at 1 m, 27 cm at 3 m.
constexpr float kCellJump = 0.03F;

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
  const Floats limit = nearest + nearest * nearest * kCellJump;
  Floats sum = Splat(0.0F);
  Floats count = Splat(0.0F);
  for (const Floats& pixel : pixels) {
    const Integers agrees = pixel <= limit;
    sum += Select(agrees, pixel, Splat(0.0F));
    count += Select(agrees, Splat(1.0F), Splat(0.0F));
  }
  // The depth limit applies to cells, not pixels. A limit per pixel would bias the last cells of an
  // oblique surface towards the camera.
  const Integers seen = nearest <= Splat(input.max_depth_m);
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

// The inverse depth of a plane is linear in pixel coordinates, and the noise of a range sensor is
// nearly constant in inverse depth. A single threshold therefore separates planes from edges at any
// depth: 2 cm at 1 m, 18 cm at 3 m.
constexpr float kPlanarBend = 0.02F;

// Stricter for one-sided slopes: at the silhouette of a curved object its curvature could be
// mistaken for a slope.
constexpr float kEdgeBend = 0.01F;

// At more than 80 degrees from normal incidence, depth determines the position of a surface poorly.
constexpr float kMinCosine = 0.17F;

// A cell next to an edge may contain flying pixels, and its slope is known from one side only.
constexpr float kEdgeWeight = 0.25F;

// The weight of a thin object in front of everything around it. Its slope is unknown and assumed to
// face the camera.
constexpr float kThinWeight = 0.1F;

// A measurement from less than 0.5 m has the weight of one from 0.5 m.
constexpr float kMaxLookWeight = 4.0F;

/// Slope of the inverse depth along one axis.
struct Slope {
  Floats per_cell;
  Integers planar;  ///< True if the surface is planar on both sides.
  Floats trust;     ///< Factor of the weight.
};

/// True if three equally spaced inverse depths lie on a plane. A missing depth is zero.
STEADYMAP_INLINE Integers IsStraight(Floats a, Floats b, Floats c, float max_bend) {
  const Floats zero = Splat(0.0F);
  return (a > zero) & (c > zero) & (Abs(a - 2.0F * b + c) < Splat(max_bend));
}

/// `neighbours` contains the inverse depths at two and one reaches before, and one and two reaches
/// after the centre.
STEADYMAP_INLINE Slope EstimateSlope(const Floats neighbours[4], Floats centre) {
  constexpr float kPerCell = 1.0F / static_cast<float>(kSurfaceReach);
  const Floats zero = Splat(0.0F);
  const Integers planar = IsStraight(neighbours[1], centre, neighbours[2], kPlanarBend);
  const Integers before =
      IsStraight(neighbours[0], neighbours[1], centre, kEdgeBend) & (neighbours[1] > zero);
  const Integers after =
      IsStraight(centre, neighbours[2], neighbours[3], kEdgeBend) & (neighbours[2] > zero);
  // A much nearer neighbour occludes the continuation of this surface. A missing neighbour counts
  // as far.
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
  const Slope along_u = EstimateSlope(beside, centre);
  const Slope along_v = EstimateSlope(above_below, centre);

  // On a plane, the mean of the neighbours equals the centre, so their average halves the noise.
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
  Floats weight = Min(inverse * inverse, Splat(kMaxLookWeight)) * cosine *
                  Load(output.support + at) * along_u.trust * along_v.trust;
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
  const int count = cells_wide - column < kLanes ? cells_wide - column : kLanes;
  memcpy(output.cells + static_cast<int64_t>(row) * cells_wide + column,
         columns,
         static_cast<uint64_t>(count) * sizeof(SurfaceCell));
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
    }
  }
}

}  // namespace
}  // namespace steadymap
