#include "core/volume/tsdf_sample.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace steadymap {
namespace {

// Voxel indices must fit in 32 bits with a margin.
constexpr double kMaxVoxelIndex = 1e9;

/// True if a point can be indexed. NaN fails the comparison; maxCoeff() could ignore it.
bool IsInRange(const Eigen::Vector3d& voxel) {
  return (voxel.array().abs() < kMaxVoxelIndex).all();
}

/// Returns the largest integer <= `value`, which must fit in 32 bits. Without SSE 4.1, std::floor
/// is a function call.
std::int32_t FloorToInteger(double value) {
  const std::int32_t truncated = static_cast<std::int32_t>(value);
  return truncated - static_cast<std::int32_t>(value < static_cast<double>(truncated));
}

/// Interpolates along x, then y, then z.
double Interpolate(const std::array<float, 8>& corners, const Eigen::Vector3d& fraction) {
  std::array<double, 4> along_x;
  for (std::size_t i = 0; i < 4; ++i) {
    along_x[i] = static_cast<double>(corners[i]) * (1.0 - fraction.x()) +
                 static_cast<double>(corners[i + 4]) * fraction.x();
  }
  const double low = along_x[0] * (1.0 - fraction.y()) + along_x[2] * fraction.y();
  const double high = along_x[1] * (1.0 - fraction.y()) + along_x[3] * fraction.y();
  return low * (1.0 - fraction.z()) + high * fraction.z();
}

/// Returns the exact gradient of the trilinear interpolant, per voxel.
Eigen::Vector3d InterpolantGradient(const std::array<float, 8>& corners,
                                    const Eigen::Vector3d& fraction) {
  const auto corner = [&corners](std::size_t i) { return static_cast<double>(corners[i]); };
  const double x0 = 1.0 - fraction.x();
  const double y0 = 1.0 - fraction.y();
  const double z0 = 1.0 - fraction.z();
  const double x1 = fraction.x();
  const double y1 = fraction.y();
  const double z1 = fraction.z();
  return {
      (corner(4) - corner(0)) * y0 * z0 + (corner(5) - corner(1)) * y0 * z1 +
          (corner(6) - corner(2)) * y1 * z0 + (corner(7) - corner(3)) * y1 * z1,
      (corner(2) - corner(0)) * x0 * z0 + (corner(3) - corner(1)) * x0 * z1 +
          (corner(6) - corner(4)) * x1 * z0 + (corner(7) - corner(5)) * x1 * z1,
      (corner(1) - corner(0)) * x0 * y0 + (corner(3) - corner(2)) * x0 * y1 +
          (corner(5) - corner(4)) * x1 * y0 + (corner(7) - corner(6)) * x1 * y1,
  };
}

}  // namespace

TsdfSampler::TsdfSampler(const VoxelReader& reader, const VoxelScale& scale)
    : reader_(reader), scale_(scale), distance_step_m_(scale.distance_step_m()) {}

const LeafView& TsdfSampler::LeafAt(LeafOrigin origin) {
  const auto place_along = [](std::int32_t coordinate) {
    return static_cast<std::size_t>(coordinate / kLeafSide) % kCachedSide;
  };
  CachedLeaf& cached =
      cache_[(place_along(origin.x) * kCachedSide + place_along(origin.y)) * kCachedSide +
             place_along(origin.z)];
  if (!cached.valid || cached.origin != origin) {
    cached = {origin, reader_.FindLeaf(origin), true};
  }
  return cached.view;
}

bool TsdfSampler::LoadCell(const Eigen::Vector3d& point_m, bool with_weight, Cell* cell) {
  const Eigen::Vector3d voxel = point_m / scale_.voxel_size_m;
  if (!IsInRange(voxel)) return false;
  Eigen::Vector3i base;
  bool one_leaf = true;
  for (int axis = 0; axis < 3; ++axis) {
    base[axis] = FloorToInteger(voxel[axis]);
    one_leaf = one_leaf && (base[axis] & (kLeafSide - 1)) != kLeafSide - 1;
  }
  cell->fraction = voxel - base.cast<double>();
  return one_leaf ? LoadCellOfOneLeaf(base, with_weight, cell)
                  : LoadCellAcrossLeaves(base, with_weight, cell);
}

bool TsdfSampler::LoadCellOfOneLeaf(const Eigen::Vector3i& base, bool with_weight, Cell* cell) {
  const LeafView& leaf = LeafAt(LeafOf(base.x(), base.y(), base.z()));
  if (!leaf) return false;
  const std::size_t first = OffsetInLeaf(base.x(), base.y(), base.z());
  // Bits of the voxels z and z + 1 of rows y and y + 1 in a word of the mask.
  const std::uint64_t square = std::uint64_t{0x303} << (first & 63);
  const std::size_t word = first >> 6;
  if ((leaf.observed[word] & leaf.observed[word + 1] & square) != square) return false;
  constexpr std::array<std::size_t, 8> kCornerOffsets = {0, 1, 8, 9, 64, 65, 72, 73};
  for (std::size_t corner = 0; corner < 8; ++corner) {
    cell->distance_m[corner] = DistanceM(leaf, first + kCornerOffsets[corner]);
  }
  if (!with_weight) return true;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    cell->weight[corner] = leaf.voxels[first + kCornerOffsets[corner]].weight();
  }
  return true;
}

bool TsdfSampler::LoadCellAcrossLeaves(const Eigen::Vector3i& base, bool with_weight, Cell* cell) {
  const bool crosses_z = (base.z() & (kLeafSide - 1)) == kLeafSide - 1;
  const LeafView* leaf = nullptr;
  for (int corner = 0; corner < 8; ++corner) {
    const std::int32_t x = base.x() + ((corner >> 2) & 1);
    const std::int32_t y = base.y() + ((corner >> 1) & 1);
    const std::int32_t z = base.z() + (corner & 1);
    if (crosses_z || (corner & 1) == 0) leaf = &LeafAt(LeafOf(x, y, z));
    const std::size_t offset = OffsetInLeaf(x, y, z);
    if (!*leaf || !IsSet(leaf->observed, offset)) return false;
    cell->distance_m[static_cast<std::size_t>(corner)] = DistanceM(*leaf, offset);
    if (with_weight) cell->weight[static_cast<std::size_t>(corner)] = leaf->voxels[offset].weight();
  }
  return true;
}

DistanceSample TsdfSampler::Sample(const Eigen::Vector3d& point_m) {
  DistanceSample sample;
  Cell cell;
  if (!LoadCell(point_m, /*with_weight=*/true, &cell)) return sample;
  sample.known = true;
  sample.distance_m = Interpolate(cell.distance_m, cell.fraction);
  sample.weight = Interpolate(cell.weight, cell.fraction);
  const Eigen::Vector3d gradient = InterpolantGradient(cell.distance_m, cell.fraction);
  const double norm = gradient.norm();
  if (norm > 0.0) sample.gradient = gradient / norm;
  sample.slope = norm / scale_.voxel_size_m;
  return sample;
}

bool TsdfSampler::SampleDistance(const Eigen::Vector3d& point_m, double* distance_m) {
  Cell cell;
  if (!LoadCell(point_m, /*with_weight=*/false, &cell)) return false;
  *distance_m = Interpolate(cell.distance_m, cell.fraction);
  return true;
}

const Voxel* TsdfSampler::NearestVoxel(const Eigen::Vector3d& point_m) {
  const Eigen::Vector3d voxel = (point_m / scale_.voxel_size_m).array() + 0.5;
  if (!(voxel.cwiseAbs().maxCoeff() < kMaxVoxelIndex)) return nullptr;
  const Eigen::Vector3i index = voxel.array().floor().cast<std::int32_t>();
  const LeafView& leaf = LeafAt(LeafOf(index.x(), index.y(), index.z()));
  const std::size_t offset = OffsetInLeaf(index.x(), index.y(), index.z());
  return leaf && IsSet(leaf.observed, offset) ? &leaf.voxels[offset] : nullptr;
}

bool TsdfSampler::SampleNearest(const Eigen::Vector3d& point_m, double* distance_m) {
  const Voxel* nearest = NearestVoxel(point_m);
  if (nearest == nullptr) return false;
  *distance_m = static_cast<double>(nearest->distance_m(distance_step_m_));
  return true;
}

bool TsdfSampler::SampleNearestPlane(const Eigen::Vector3d& point_m,
                                     const Eigen::Vector3d& normal,
                                     double* distance_m) {
  if (!SampleNearest(point_m, distance_m)) return false;
  const Eigen::Vector3d voxel = (point_m / scale_.voxel_size_m).array() + 0.5;
  const Eigen::Vector3d center_m = voxel.array().floor() * scale_.voxel_size_m;
  *distance_m += normal.dot(point_m - center_m);
  return true;
}

bool TsdfSampler::IsMeasured(const Eigen::Vector3d& point_m) {
  const Voxel* nearest = NearestVoxel(point_m);
  return nearest != nullptr && nearest->weight() > kWeightUnit;
}

double TsdfSampler::EmptyRun(const Eigen::Vector3d& point_m,
                             const Eigen::Vector3d& unit_direction) {
  const Eigen::Vector3d voxel = point_m / scale_.voxel_size_m;
  if (!IsInRange(voxel)) return 0.0;
  const Eigen::Vector3i base = voxel.array().floor().cast<std::int32_t>();
  const LeafOrigin origin = LeafOf(base.x(), base.y(), base.z());
  const int side = LeafAt(origin) ? 1 : reader_.EmptySideAt(origin);
  const Eigen::Vector3d low(base.x() & -side, base.y() & -side, base.z() & -side);
  double run_voxels = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    if (unit_direction[axis] == 0.0) continue;
    const double border = low[axis] + (unit_direction[axis] > 0.0 ? side : 0);
    run_voxels = std::min(run_voxels, (border - voxel[axis]) / unit_direction[axis]);
  }
  return run_voxels * scale_.voxel_size_m;
}

}  // namespace steadymap
