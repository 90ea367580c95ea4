#include "core/object_parts.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace steadymap {
namespace {

LeafOrigin Shift(LeafOrigin origin, const Eigen::Vector3i& voxels) {
  return {origin.x + voxels.x(), origin.y + voxels.y(), origin.z + voxels.z()};
}

void TakeBetterVoxels(const LeafView& leaf, LeafVoxels* voxels) {
  for (std::size_t offset = 0; offset < kLeafVoxels; ++offset) {
    if (!IsSet(leaf.observed, offset) || leaf.weight[offset] <= voxels->weight[offset]) continue;
    voxels->distance_m[offset] = leaf.distance_m[offset];
    voxels->weight[offset] = leaf.weight[offset];
    voxels->observed[offset >> 6] |= std::uint64_t{1} << (offset & 63);
    if (leaf.color == nullptr) continue;
    voxels->color[offset] = leaf.color[offset];
    voxels->has_color = true;
  }
}

void TakeBetterEvidence(const LeafEvidence& evidence, LeafEvidence* target) {
  target->confirmed = std::max(target->confirmed, evidence.confirmed);
  for (std::size_t cell = 0; cell < kEvidenceCells; ++cell) {
    target->score[cell] = std::max(target->score[cell], evidence.score[cell]);
  }
}

}  // namespace

bool ShareLattice(const ObjectState& a, const ObjectState& b) {
  return a.T_world_object.yaw_rad == 0.0 && b.T_world_object.yaw_rad == 0.0;
}

MovedLeaves CopyVoxels(const TrackedObject& from, const VoxelScale& scale, TrackedObject* into) {
  assert(ShareLattice(from.state(), into->state()));
  const Eigen::Vector3d offset_voxels =
      (from.state().T_world_object.position_world - into->state().T_world_object.position_world) /
      scale.voxel_size_m;
  const Eigen::Vector3i shift = offset_voxels.array().round().cast<int>();
  TsdfGrid& volume = into->MutableVolume();
  MovedLeaves moved;
  LeafVoxels voxels;
  from.volume().ForEachLeaf([&](LeafOrigin origin, const LeafView& leaf) {
    const LeafOrigin target = Shift(origin, shift);
    volume.LoadLeaf(target, &voxels);
    TakeBetterVoxels(leaf, &voxels);
    volume.StoreLeaf(target, voxels);
    moved.from.push_back(origin);
    moved.into.push_back(target);
  });
  for (const LeafEvidence& evidence : from.state().evidence.leaves) {
    TakeBetterEvidence(evidence,
                       &into->state().evidence.MutableLeaf(Shift(evidence.origin, shift)));
  }
  into->UpdateSurface(moved.into);
  return moved;
}

std::vector<LeafOrigin> MoveGoneVoxels(int max_score, TrackedObject* object, TrackedObject* part) {
  TsdfGrid& volume = object->MutableVolume();
  TsdfGrid& part_volume = part->MutableVolume();
  std::vector<LeafOrigin> changed;
  LeafVoxels voxels;
  for (LeafEvidence& leaf : object->state().evidence.leaves) {
    LeafVoxels gone{};
    volume.LoadLeaf(leaf.origin, &voxels);
    gone.has_color = voxels.has_color;
    for (std::size_t offset = 0; offset < kLeafVoxels; ++offset) {
      if (leaf.score[EvidenceCellOf(offset)] > max_score || !IsSet(voxels.observed, offset)) {
        continue;
      }
      const std::uint64_t bit = std::uint64_t{1} << (offset & 63);
      gone.distance_m[offset] = std::exchange(voxels.distance_m[offset], 0.0F);
      gone.weight[offset] = std::exchange(voxels.weight[offset], 0.0F);
      gone.color[offset] = std::exchange(voxels.color[offset], 0U);
      gone.observed[offset >> 6] |= bit;
      voxels.observed[offset >> 6] &= ~bit;
    }
    for (std::int8_t& score : leaf.score) {
      if (score <= max_score) score = 0;
    }
    if (gone.observed == LeafMask{}) continue;
    volume.StoreLeaf(leaf.origin, voxels);
    part_volume.StoreLeaf(leaf.origin, gone);
    changed.push_back(leaf.origin);
  }
  object->UpdateSurface(changed);
  part->UpdateSurface(changed);
  return changed;
}

}  // namespace steadymap
