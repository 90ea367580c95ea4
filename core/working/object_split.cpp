#include "core/working/object_split.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <set>
#include <utility>

#include "core/volume/tsdf_sample.h"
#include "core/volume/voxel_index.h"

namespace steadymap {
namespace {

LeafOrigin Shift(LeafOrigin origin, const Eigen::Vector3i& voxels) {
  return {origin.x + voxels.x(), origin.y + voxels.y(), origin.z + voxels.z()};
}

void TakeBetterVoxels(const LeafView& leaf, LeafVoxels* voxels) {
  for (std::size_t offset = 0; offset < kLeafVoxels; ++offset) {
    const Voxel voxel = leaf.voxels[offset];
    if (!IsSet(leaf.observed, offset) ||
        voxel.weight_units() <= voxels->voxels[offset].weight_units()) {
      continue;
    }
    voxels->voxels[offset] = voxel;
    SetBit(offset, &voxels->observed);
    if (leaf.color == nullptr) continue;
    voxels->color[offset] = leaf.color[offset];
    voxels->has_color = true;
  }
}

/// Returns the leaves in the target frame that the leaves of a volume may intersect.
std::set<LeafOrigin> LeavesUnder(const TsdfGrid& volume,
                                 const Eigen::Isometry3d& T_target_volume,
                                 const VoxelScale& scale) {
  std::set<LeafOrigin> leaves;
  volume.ForEachLeaf([&](LeafOrigin origin, const LeafView&) {
    Eigen::AlignedBox3d bounds;
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d index =
          VoxelIndexAt(origin, 0).cast<double>() +
          Eigen::Vector3d(corner & 1, corner >> 1 & 1, corner >> 2) * kLeafSide;
      bounds.extend(T_target_volume * (index * scale.voxel_size_m) / scale.voxel_size_m);
    }
    const Eigen::Vector3i low = bounds.min().array().floor().cast<int>();
    const Eigen::Vector3i high = bounds.max().array().ceil().cast<int>();
    const LeafOrigin first = LeafOf(low.x(), low.y(), low.z());
    for (std::int32_t x = first.x; x <= high.x(); x += kLeafSide) {
      for (std::int32_t y = first.y; y <= high.y(); y += kLeafSide) {
        for (std::int32_t z = first.z; z <= high.z(); z += kLeafSide) leaves.insert({x, y, z});
      }
    }
  });
  return leaves;
}

/// Stores a sample as a voxel with at most `max_weight`.
void StoreSample(const DistanceSample& sample,
                 double max_weight,
                 const VoxelScale& scale,
                 std::size_t offset,
                 LeafVoxels* voxels) {
  const long steps = std::lround(sample.distance_m / static_cast<double>(scale.distance_step_m()));
  const long units =
      std::lround(std::min(sample.weight, max_weight) / static_cast<double>(kWeightUnit));
  voxels->voxels[offset] = Voxel(static_cast<int>(steps), static_cast<int>(std::max(units, 1L)));
  SetBit(offset, &voxels->observed);
}

void TakeBetterEvidence(const LeafEvidence& evidence, LeafEvidence* target) {
  target->last_look = std::max(target->last_look, evidence.last_look);
  for (std::size_t cell = 0; cell < kEvidenceCells; ++cell) {
    // A score of zero says nothing.
    if (evidence.score[cell] == 0) continue;
    target->score[cell] = target->score[cell] == 0
                              ? evidence.score[cell]
                              : std::max(target->score[cell], evidence.score[cell]);
  }
}

/// The position of an evidence cell among all cells of its object.
using CellPlace = std::array<int, 3>;

CellPlace PlaceOf(LeafOrigin origin, std::uint8_t cell) {
  return {origin.x / kEvidenceSide + (cell >> 4),
          origin.y / kEvidenceSide + (cell >> 2 & 3),
          origin.z / kEvidenceSide + (cell & 3)};
}

/// Moves the cells of `cells` adjacent to `cell` (26-neighbourhood) to the end of `group`.
void TakeNeighbours(const CellPlace& cell,
                    std::set<CellPlace>* cells,
                    std::vector<CellPlace>* group) {
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        const CellPlace neighbour = {cell[0] + x, cell[1] + y, cell[2] + z};
        if (cells->erase(neighbour) > 0) group->push_back(neighbour);
      }
    }
  }
}

/// Returns the absent evidence cells of an object.
std::set<CellPlace> FindGoneCells(const TrackedObject& object, const GoneScores& scores) {
  std::vector<CellPlace> gone;
  std::set<CellPlace> doubted;
  for (const LeafEvidence& leaf : object.state().evidence.leaves) {
    for (std::size_t cell = 0; cell < kEvidenceCells; ++cell) {
      const CellPlace place = PlaceOf(leaf.origin, static_cast<std::uint8_t>(cell));
      if (leaf.score[cell] <= scores.gone) {
        gone.push_back(place);
      } else if (leaf.score[cell] <= scores.beside_gone) {
        doubted.insert(place);
      }
    }
  }
  for (std::size_t next = 0; next < gone.size(); ++next) {
    TakeNeighbours(CellPlace(gone[next]), &doubted, &gone);
  }
  return {gone.begin(), gone.end()};
}

}  // namespace

bool ShareLattice(const ObjectState& a, const ObjectState& b) {
  return a.T_world_object.yaw_rad == 0.0 && b.T_world_object.yaw_rad == 0.0;
}

void CopyVoxels(const TrackedObject& from, const VoxelScale& scale, ObjectEdit* into) {
  const ObjectState& target_state = into->object().state();
  assert(ShareLattice(from.state(), target_state));
  const Eigen::Vector3d offset_voxels =
      (from.state().T_world_object.position_world - target_state.T_world_object.position_world) /
      scale.voxel_size_m;
  const Eigen::Vector3i shift = offset_voxels.array().round().cast<int>();
  LeafVoxels voxels;
  from.volume().ForEachLeaf([&](LeafOrigin origin, const LeafView& leaf) {
    const LeafOrigin target = Shift(origin, shift);
    into->object().volume().LoadLeaf(target, &voxels);
    TakeBetterVoxels(leaf, &voxels);
    into->StoreLeaf(target, voxels);
  });
  for (const LeafEvidence& evidence : from.state().evidence.leaves) {
    TakeBetterEvidence(evidence,
                       &into->state().evidence.MutableLeaf(Shift(evidence.origin, shift)));
  }
}

void ResampleVoxels(const TrackedObject& from,
                    const Eigen::Isometry3d& T_world_from,
                    double max_weight,
                    const VoxelScale& scale,
                    ObjectEdit* into) {
  const Eigen::Isometry3d T_from_into =
      T_world_from.inverse() * into->object().state().T_world_object.ToIsometry();
  const std::set<LeafOrigin> targets = LeavesUnder(from.volume(), T_from_into.inverse(), scale);
  TsdfSampler sampler(from.volume(), scale);
  LeafVoxels voxels;
  for (const LeafOrigin& origin : targets) {
    into->object().volume().LoadLeaf(origin, &voxels);
    bool has_changed = false;
    for (std::size_t offset = 0; offset < kLeafVoxels; ++offset) {
      if (IsSet(voxels.observed, offset)) continue;
      const Eigen::Vector3d center_into =
          VoxelIndexAt(origin, offset).cast<double>() * scale.voxel_size_m;
      const DistanceSample sample = sampler.Sample(T_from_into * center_into);
      if (!sample.known) continue;
      StoreSample(sample, max_weight, scale, offset, &voxels);
      has_changed = true;
    }
    if (has_changed) into->StoreLeaf(origin, voxels);
  }
}

void MoveGoneVoxels(const GoneScores& scores, ObjectEdit* object, ObjectEdit* part) {
  const std::set<CellPlace> gone_cells = FindGoneCells(object->object(), scores);
  LeafVoxels voxels;
  for (LeafEvidence& leaf : object->state().evidence.leaves) {
    std::array<bool, kEvidenceCells> is_gone{};
    for (std::size_t cell = 0; cell < kEvidenceCells; ++cell) {
      is_gone[cell] = gone_cells.contains(PlaceOf(leaf.origin, static_cast<std::uint8_t>(cell)));
    }
    LeafVoxels gone{};
    object->object().volume().LoadLeaf(leaf.origin, &voxels);
    gone.has_color = voxels.has_color;
    for (std::size_t offset = 0; offset < kLeafVoxels; ++offset) {
      if (!is_gone[EvidenceCellOf(offset)] || !IsSet(voxels.observed, offset)) continue;
      gone.voxels[offset] = std::exchange(voxels.voxels[offset], Voxel());
      gone.color[offset] = std::exchange(voxels.color[offset], 0U);
      SetBit(offset, &gone.observed);
      ClearBit(offset, &voxels.observed);
    }
    // Scores are also reset in cells without voxels: surface that appears there belongs to another
    // object.
    std::array<std::int8_t, kEvidenceCells> gone_score{};
    for (std::size_t cell = 0; cell < kEvidenceCells; ++cell) {
      if (!is_gone[cell]) continue;
      gone_score[cell] = std::exchange(leaf.score[cell], std::int8_t{0});
    }
    if (gone.observed == LeafMask{}) continue;
    part->state().evidence.MutableLeaf(leaf.origin).score = gone_score;
    object->StoreLeaf(leaf.origin, voxels);
    part->StoreLeaf(leaf.origin, gone);
  }
}

}  // namespace steadymap
