#pragma once

// The kernel from surface cells to the voxels of a leaf, a part of tsdf_kernel_body.h.

#include "core/integration/kernel_lanes.h"
#include "core/integration/tsdf_kernel.h"

namespace steadymap {
namespace {

// Decrease of the weight with the squared lateral offset, in voxels, between a voxel and the
// measured surface. The weight of the floor must stay sufficient: a low camera at 3 m measures it
// with an offset of six voxels.
constexpr float kStraying = 0.5F;

// The weight is bounded, so that a long-observed voxel can still change.
constexpr float kMaxWeight = 63.0F;

// A voxel is converged if its weight is at least this multiple of the current measurement's weight,
// or the maximum. A converged voxel ignores differences within the dead band as noise. More than a
// voxel off the surface, where no mesh vertex is interpolated, a smaller multiple suffices. The
// dead band grows with the depth, as does the sensor noise, and with the distance from the surface,
// where a distance depends on the viewpoint.
constexpr float kSettledLooks = 32.0F;
constexpr float kSettledLooksAside = 8.0F;
constexpr float kDeadBandVoxels = 0.1F;
constexpr float kDeadBandPerMetre = 0.1F;
constexpr float kDeadBandPerSquareMetre = 0.005F;

// Colour is fused within the range of interpolation at the surface.
constexpr float kColorBandVoxels = 1.75F;
constexpr uint32_t kMaxColorLooks = 32;
constexpr int kColorDeadBand = 16;

// Behind the surface, the weight of a measurement is full within the noise and fades over these
// voxels: the space behind is not observed, and thin objects observed from both sides keep both.
constexpr float kFadeVoxels = 1.0F;

// Up to the diagonal of a cell behind the surface, distances are extrapolated with the smallest
// weight, so that the eight voxels around each point of the surface are known and rays can be cast.
// Extrapolated voxels give no surface.
constexpr float kKnownVoxels = 1.74F;

// Expected distance of a voxel behind a surface that a ray refutes, if the ray passes close to a
// silhouette.
constexpr float kMinFreeVoxels = 0.5F;

constexpr int kVoxelsPerCacheLine = 16;

constexpr float kWeightsPerUnit = 1.0F / kWeightUnit;

/// Fuses `seen` into the mean `old_color`, whose byte 3 is the number of measurements.
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

/// The constants of the loop over the rows of a leaf. A copy, so that stores to voxels cannot alias
/// them and they stay in registers.
struct RowConstants {
  explicit STEADYMAP_INLINE RowConstants(const LeafKernelFrame& frame)
      : along_x(kLaneIndex * frame.step_z[0]),
        along_y(kLaneIndex * frame.step_z[1]),
        along_z(kLaneIndex * frame.step_z[2]),
        owner(static_cast<int32_t>(frame.owner) - Integers{}),
        cells(frame.cells),
        clearance(frame.clearance),
        inverse_fx(1.0F / frame.fx),
        clears(frame.clears ? ~Integers{} : Integers{}),
        min_free_m(kMinFreeVoxels * frame.voxel_size_m),
        cells_wide(frame.cells_wide),
        fx(frame.fx),
        fy(frame.fy),
        image_x(frame.cx + 0.5F),
        image_y(frame.cy + 0.5F),
        image_width(static_cast<float>(frame.cells_wide)),
        image_height(static_cast<float>(frame.cells_high)),
        truncation_m(frame.truncation_m),
        fade_scale(1.0F / (kFadeVoxels * frame.voxel_size_m)),
        known_m(kKnownVoxels * frame.voxel_size_m),
        noise(frame.noise),
        inverse_voxel_size2(1.0F / (frame.voxel_size_m * frame.voxel_size_m)),
        voxel_size_m(frame.voxel_size_m),
        dead_band_m(kDeadBandVoxels * frame.voxel_size_m),
        color_band_m(kColorBandVoxels * frame.voxel_size_m),
        distance_step_m(frame.distance_step_m),
        steps_per_m(1.0F / frame.distance_step_m) {}

  Floats along_x;  ///< Offsets of the eight voxels of a row from its first voxel, camera frame.
  Floats along_y;
  Floats along_z;
  Integers owner;
  const SurfaceCell* cells;
  const uint8_t* clearance;
  float inverse_fx;
  Integers clears;
  float min_free_m;
  int32_t cells_wide;
  float fx;
  float fy;
  float image_x;  ///< Principal point plus 0.5: truncation then gives the nearest cell.
  float image_y;
  float image_width;
  float image_height;
  float truncation_m;
  float fade_scale;
  float known_m;
  KernelNoise noise;
  float inverse_voxel_size2;
  float voxel_size_m;
  float dead_band_m;  ///< At the surface, without the terms of distance and depth.
  float color_band_m;
  float distance_step_m;
  float steps_per_m;
};

/// The measurements of the frame for the eight voxels of a row.
struct RowEvidence {
  Floats distance_m;
  Floats weight;
  Floats depth_m;  ///< Of the voxels.
  Integers valid;
  Integers free;  ///< Valid voxels in front of the truncation band.
  int32_t cell[kLanes];
};

/// Loads the first or second half of eight cells as four columns.
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

/// Computes the distances of eight voxels from the surface. Returns one bit for each voxel in the
/// truncation band or in front of it.
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
  const Integers in_front = distance_m >= Splat(constants.truncation_m);
  evidence->free = constants.clears & in_image & in_front;
  evidence->valid =
      evidence->free | (in_image & ~in_front & (distance_m > Splat(-constants.truncation_m)));
  return ToBits(evidence->valid);
}

/// Computes the weights of the measurements of `MeasureRow`; returns false if all are invalid.
STEADYMAP_INLINE bool WeighRow(const RowConstants& constants, RowEvidence* evidence) {
  const Floats zero = Splat(0.0F);
  const Floats distance_m = evidence->distance_m;
  Floats look[4];
  LoadHalfCells(constants.cells, evidence->cell, 1, look);
  const Floats sigma_m = look[0] * look[0] * constants.noise.growth_per_m + constants.noise.floor_m;
  const Floats fade =
      Max(Min((distance_m + sigma_m) * constants.fade_scale + 1.0F, Splat(1.0F)), zero);
  // On an oblique surface, the measured point has a lateral offset from the foot of the voxel's
  // perpendicular. The error of the tangent plane on a curved surface grows with this offset.
  const Floats along_ray_m = look[0] - evidence->depth_m;
  const Floats beside_voxels2 =
      (along_ray_m * along_ray_m - distance_m * distance_m) * constants.inverse_voxel_size2;
  const Floats straying = 1.0F / (1.0F + Max(beside_voxels2, zero) * kStraying);
  const Integers noise = along_ray_m <= sigma_m * (kSigmas * kDifferenceSigma);
  evidence->valid = evidence->valid & ~(evidence->free & noise);
  // A ray that passes in front of the band is as certain as a surface measured at the voxel.
  const Floats inverse_z = 1.0F / evidence->depth_m;
  const Floats free_weight = Min(inverse_z * inverse_z, Splat(kMaxLookWeight));
  const Floats min_weight =
      Select((distance_m + sigma_m > Splat(-constants.known_m)) & (look[1] > zero),
             Splat(kWeightUnit),
             zero);
  evidence->weight =
      Select(evidence->free, free_weight, Max(look[1] * fade * straying, min_weight));
  const Integers fused = (Abs(along_ray_m) < Splat(kMaxRayBand * constants.truncation_m)) &
                         (reinterpret_cast<Integers>(look[3]) == constants.owner);
  evidence->valid =
      evidence->valid & (evidence->free | fused) & (evidence->weight >= Splat(kWeightUnit));
  if (ToBits(evidence->free) != 0) {
    Floats clearance_cells;
    for (int lane = 0; lane < kLanes; ++lane) {
      clearance_cells[lane] = static_cast<float>(constants.clearance[evidence->cell[lane]]);
    }
    const Floats clearance_m = clearance_cells * evidence->depth_m * constants.inverse_fx;
    evidence->distance_m =
        Select(evidence->free, Min(clearance_m, Splat(constants.truncation_m)), distance_m);
  }
  return ToBits(evidence->valid) != 0;
}

/// Fuses the measurements into eight voxels by a weighted mean (Curless and Levoy, 1996). Returns
/// one bit for each changed voxel.
STEADYMAP_INLINE uint32_t FuseRow(const RowConstants& constants,
                                  const RowEvidence& evidence,
                                  uint32_t* voxels) {
  Integers old_voxels;
  memcpy(&old_voxels, voxels, sizeof(old_voxels));
  const Floats old_distance_m =
      __builtin_convertvector(old_voxels >> 16, Floats) * constants.distance_step_m;
  const Floats old_weight = __builtin_convertvector(old_voxels & 0xFFFF, Floats) * kWeightUnit;
  const Floats aside_m = Abs(old_distance_m);
  const Floats dead_band_m = Splat(constants.dead_band_m) + aside_m * kDeadBandPerMetre +
                             evidence.depth_m * evidence.depth_m * kDeadBandPerSquareMetre;
  const Floats settled_looks = Select(
      aside_m < Splat(constants.voxel_size_m), Splat(kSettledLooks), Splat(kSettledLooksAside));
  const Integers settled = (old_weight >= Min(evidence.weight * settled_looks, Splat(kMaxWeight))) &
                           (Abs(evidence.distance_m - old_distance_m) < dead_band_m);
  // The clearance of a ray is a lower bound of the distance.
  const Integers known_free =
      evidence.free & (old_weight > Splat(0.0F)) & (old_distance_m >= evidence.distance_m);
  const Integers refuted = evidence.free & (old_distance_m <= Splat(0.0F));
  const Floats distance_now_m =
      Select(refuted, Max(evidence.distance_m, Splat(constants.min_free_m)), evidence.distance_m);
  // An extrapolated distance never changes a measured one. Of two, the larger is kept, since behind
  // a convex surface a tangent plane gives a smaller distance than the true one.
  const Integers extrapolated = evidence.weight <= Splat(kWeightUnit);
  const Integers was_extrapolated = old_weight <= Splat(kWeightUnit);
  const Integers known_better =
      extrapolated & (old_weight > Splat(0.0F)) &
      (~was_extrapolated | (old_distance_m + dead_band_m >= evidence.distance_m));
  const Integers fuse = evidence.valid & ~settled & ~known_free & ~known_better;
  const Floats kept_weight = Select(was_extrapolated, Splat(0.0F), old_weight);
  const Floats weight_now =
      Select(evidence.free & was_extrapolated, Splat(kWeightUnit), evidence.weight);
  const Floats total = kept_weight + weight_now;
  const Floats mean_m = (old_distance_m * kept_weight + distance_now_m * weight_now) / total;
  const Integers new_steps =
      __builtin_convertvector(Round(mean_m * constants.steps_per_m), Integers);
  const Integers new_units = __builtin_convertvector(
      Min(Round(total * kWeightsPerUnit), Splat(kMaxWeight * kWeightsPerUnit)), Integers);
  const Integers new_voxels = (new_steps << 16) | new_units;
  const Integers kept_voxels = (fuse & new_voxels) | (~fuse & old_voxels);
  memcpy(voxels, &kept_voxels, sizeof(kept_voxels));
  return ToBits(kept_voxels != old_voxels);
}

/// Fuses the colours of eight voxels near the surface. Returns true if any changed.
STEADYMAP_INLINE bool FuseRowColors(const RowConstants& constants,
                                    const RowEvidence& evidence,
                                    uint32_t* color) {
  const Integers near_surface =
      evidence.valid & ~evidence.free & (Abs(evidence.distance_m) < Splat(constants.color_band_m));
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
    // The voxels are fetched from memory during the measurement of the rows.
    const int slab = x * kLeafSide * kLeafSide;
    for (int voxel = slab; voxel < slab + kLeafSide * kLeafSide; voxel += kVoxelsPerCacheLine) {
      __builtin_prefetch(leaf.voxels + voxel, 1);
    }
    // All rows are measured before any is fused. The processor cannot predict which rows the band
    // intersects, and a mispredicted branch per row would cost more than the measurement.
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
      const uint32_t moved = FuseRow(constants, evidence, leaf.voxels + offset);
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
