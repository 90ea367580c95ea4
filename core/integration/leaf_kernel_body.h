#pragma once

// From surface cells to the voxels of a leaf: part of tsdf_kernel_body.h.

#include "core/integration/kernel_lanes.h"
#include "core/integration/tsdf_kernel.h"

namespace steadymap {
namespace {

// How fast trust falls with the square of the voxels that the surface was seen aside. The floor
// must stay: a low camera sees it from three metres off, six voxels aside.
constexpr float kStraying = 0.5F;

// An old place must still be able to change: evidence is capped.
constexpr float kMaxWeight = 63.0F;

// Settled voxels stay put (decisions.md 2): after this many looks as good as the one at hand, or
// all that count, an innovation within the dead band is noise. More than a voxel aside from the
// surface, where no mesh vertex is interpolated, fewer looks do. The band grows with depth as the
// sensor's noise does, and aside from the surface, where a distance depends on where it is measured
// from.
constexpr float kSettledLooks = 32.0F;
constexpr float kSettledLooksAside = 8.0F;
constexpr float kDeadBandVoxels = 0.1F;
constexpr float kDeadBandPerMetre = 0.1F;
constexpr float kDeadBandPerSquareMetre = 0.005F;

// Colour is taken where interpolation can reach it.
constexpr float kColorBandVoxels = 1.75F;
constexpr uint32_t kMaxColorLooks = 32;
constexpr int kColorDeadBand = 16;

constexpr int kFloatsPerCacheLine = 16;

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
      : along_x(kLaneIndex * frame.step_z[0]),
        along_y(kLaneIndex * frame.step_z[1]),
        along_z(kLaneIndex * frame.step_z[2]),
        owner(static_cast<int32_t>(frame.owner) - Integers{}),
        cells(frame.cells),
        cells_wide(frame.cells_wide),
        fx(frame.fx),
        fy(frame.fy),
        image_x(frame.cx + 0.5F),
        image_y(frame.cy + 0.5F),
        image_width(static_cast<float>(frame.cells_wide)),
        image_height(static_cast<float>(frame.cells_high)),
        truncation_m(frame.truncation_m),
        fade_from_m(-frame.voxel_size_m),
        fade_scale(1.0F / (frame.truncation_m - frame.voxel_size_m)),
        inverse_voxel_size2(1.0F / (frame.voxel_size_m * frame.voxel_size_m)),
        voxel_size_m(frame.voxel_size_m),
        dead_band_m(kDeadBandVoxels * frame.voxel_size_m),
        color_band_m(kColorBandVoxels * frame.voxel_size_m),
        distance_step_m(frame.distance_step_m),
        steps_per_m(1.0F / frame.distance_step_m) {}

  Floats along_x;  ///< From a row's first voxel to each of its voxels, camera frame.
  Floats along_y;
  Floats along_z;
  Integers owner;
  const SurfaceCell* cells;
  int32_t cells_wide;
  float fx;
  float fy;
  float image_x;  ///< Principal point, shifted so that truncation finds the nearest cell.
  float image_y;
  float image_width;
  float image_height;
  float truncation_m;
  float fade_from_m;
  float fade_scale;
  float inverse_voxel_size2;
  float voxel_size_m;
  float dead_band_m;  ///< At the surface, before the camera.
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
    memcpy(&quads[lane], cell + half * static_cast<int64_t>(sizeof(Quad)), sizeof(Quad));
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

/// Looks up the surface at eight voxels; one bit for each that lies in its truncation band.
STEADYMAP_INLINE uint32_t MeasureRow(const RowConstants& constants,
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
  const Integers column = __builtin_convertvector(Select(in_image, u, zero), Integers);
  const Integers row = __builtin_convertvector(Select(in_image, v, zero), Integers);
  const Integers cell = row * constants.cells_wide + column;
  memcpy(evidence->cell, &cell, sizeof(cell));
  Floats plane[4];
  LoadHalfCells(constants.cells, evidence->cell, 0, plane);
  const Floats distance_m = plane[3] - (plane[0] * x + plane[1] * y + plane[2] * z);
  evidence->distance_m = distance_m;
  evidence->depth_m = z;
  evidence->valid = in_image & (Abs(distance_m) < Splat(constants.truncation_m));
  return ToBits(evidence->valid);
}

/// Weighs what `MeasureRow` found; false if none of it counts.
STEADYMAP_INLINE bool WeighRow(const RowConstants& constants, RowEvidence* evidence) {
  const Floats zero = Splat(0.0F);
  const Floats distance_m = evidence->distance_m;
  Floats look[4];
  LoadHalfCells(constants.cells, evidence->cell, 1, look);
  // Behind the surface nothing was seen: trust fades from one voxel to the end of the band.
  const Floats fade = Select(distance_m < Splat(constants.fade_from_m),
                             (constants.truncation_m + distance_m) * constants.fade_scale,
                             Splat(1.0F));
  // Along a slanted ray the surface was seen beside the voxel's foot on it. The further beside, the
  // more a curved surface has strayed from the tangent plane.
  const Floats along_ray_m = look[0] - evidence->depth_m;
  const Floats beside_voxels2 =
      (along_ray_m * along_ray_m - distance_m * distance_m) * constants.inverse_voxel_size2;
  const Floats straying = 1.0F / (1.0F + Max(beside_voxels2, zero) * kStraying);
  evidence->weight = look[1] * fade * straying;
  evidence->valid = evidence->valid &
                    (Abs(along_ray_m) < Splat(kMaxRayBand * constants.truncation_m)) &
                    (evidence->weight >= Splat(kWeightUnit)) &
                    (reinterpret_cast<Integers>(look[3]) == constants.owner);
  return ToBits(evidence->valid) != 0;
}

/// Fuses evidence into eight voxels; one bit a voxel that changed.
STEADYMAP_INLINE uint32_t FuseRow(const RowConstants& constants,
                                  const RowEvidence& evidence,
                                  float* distance_m,
                                  float* weight) {
  const Floats old_distance_m = Load(distance_m);
  const Floats old_weight = Load(weight);
  const Floats aside_m = Abs(old_distance_m);
  const Floats dead_band_m = Splat(constants.dead_band_m) + aside_m * kDeadBandPerMetre +
                             evidence.depth_m * evidence.depth_m * kDeadBandPerSquareMetre;
  const Floats settled_looks = Select(
      aside_m < Splat(constants.voxel_size_m), Splat(kSettledLooks), Splat(kSettledLooksAside));
  const Integers settled = (old_weight >= Min(evidence.weight * settled_looks, Splat(kMaxWeight))) &
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
    // The voxels come from memory while the rows are measured.
    const int slab = x * kLeafSide * kLeafSide;
    for (int voxel = slab; voxel < slab + kLeafSide * kLeafSide; voxel += kFloatsPerCacheLine) {
      __builtin_prefetch(leaf.distance_m + voxel, 1);
      __builtin_prefetch(leaf.weight + voxel, 1);
    }
    // All rows are measured before any is fused: which ones the band meets is hard to foretell, and
    // a branch for each would cost more than its measurement.
    RowEvidence rows[kLeafSide];
    uint32_t rows_in_band = 0;
    for (int y = 0; y < kLeafSide; ++y) {
      float base[3];
      for (int axis = 0; axis < 3; ++axis) {
        base[axis] = leaf.origin[axis] + static_cast<float>(x) * frame.step_x[axis] +
                     static_cast<float>(y) * frame.step_y[axis];
      }
      rows_in_band |= (MeasureRow(constants, base, &rows[y]) != 0 ? 1U : 0U) << y;
    }
    for (; rows_in_band != 0; rows_in_band &= rows_in_band - 1) {
      const int y = __builtin_ctz(rows_in_band);
      RowEvidence& evidence = rows[y];
      if (!WeighRow(constants, &evidence)) continue;
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
}  // namespace steadymap
