#include "core/policy/voxel_change.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/volume/voxel_index.h"

namespace steadymap {
namespace {

// Rays that are walked to find the leaves in view stand so many tiles apart: 16 pixels, less than a
// leaf of 0.4 m at 5 m.
constexpr int kRayStrideTiles = 4;

// As integration does it (leaf_kernel_body.h).
constexpr float kMaxWeight = 63.0F;

// A look from nearer than this weighs no more.
constexpr float kNearestLookM = 0.5F;

// A change of which so many voxels tell the same is that.
constexpr double kDecidingShare = 0.7;

/// Fuses the sight of free space into one voxel.
void FuseFreeLook(float look_weight, std::size_t offset, LeafVoxels* voxels) {
  Voxel& voxel = voxels->voxels[offset];
  const float weight = voxel.weight();
  const float total = weight + look_weight;
  const float steps = (static_cast<float>(voxel.distance_steps()) * weight +
                       static_cast<float>(kMaxDistanceSteps) * look_weight) /
                      total;
  const float capped = std::min(total, kMaxWeight);
  voxel = Voxel(static_cast<int>(std::lround(steps)),
                std::max(static_cast<int>(std::lround(capped / kWeightUnit)), 1));
  SetBit(offset, &voxels->observed);
}

void ClearVoxel(std::size_t offset, LeafVoxels* voxels) {
  voxels->voxels[offset] = Voxel();
  voxels->color[offset] = 0;
  ClearBit(offset, &voxels->observed);
}

void TakeVoxel(const LeafView& from, std::size_t offset, LeafVoxels* voxels) {
  voxels->voxels[offset] = from.voxels[offset];
  SetBit(offset, &voxels->observed);
  if (from.color == nullptr) return;
  voxels->color[offset] = from.color[offset];
  voxels->has_color = true;
}

}  // namespace

VoxelChangeMapper::VoxelChangeMapper(const MapConfig& config,
                                     const VoxelChangeParameters& parameters)
    : parameters_(parameters), integrator_(config) {}

void VoxelChangeMapper::Process(const Frame& frame, SemanticCloud* cloud, WorkingMap* map) {
  map_ = map;
  SessionVolume fresh(map);
  if (!fresh.empty() && (map->now() - fresh.last_fused()).seconds() > parameters_.visit_gap_s) {
    std::vector<LeafOrigin> all;
    fresh.ForEachLeaf([&all](LeafOrigin origin, const LeafView&) { all.push_back(origin); });
    std::sort(all.begin(), all.end());
    TakeOver(all, fresh);
    fresh.Discard();
  }
  integrator_.SetFrame(*cloud);
  fresh.Fuse(&integrator_);
  if (map->revision().value() % parameters_.frames_per_comparison != 0) return;
  tiles_.Compute(frame.depth);
  const ViewFreeSpace view(*cloud, tiles_, parameters_.max_depth_m);
  const std::vector<LeafOrigin>& in_view = LeavesInView(view);
  for (const LeafOrigin& origin : in_view) ClearLeaf(view, origin, &fresh);
  TakeOver(in_view, fresh);
}

/// The leaves that the frame looks through, and those of the surface it sees.
const std::vector<LeafOrigin>& VoxelChangeMapper::LeavesInView(const ViewFreeSpace& view) {
  const VoxelScale& scale = map_->scale();
  const auto leaf_size_m = static_cast<float>(scale.leaf_size_m());
  // A leaf reaches half a voxel below the centre of its lowest voxel.
  const Eigen::Vector3f half_voxel = Eigen::Vector3f::Constant(0.5F / kLeafSide);
  const Eigen::Vector3f camera_leaves = view.camera_world() / leaf_size_m + half_voxel;
  const Eigen::Vector3f base = camera_leaves.array().floor();
  const Eigen::Vector3i base_leaf = base.cast<std::int32_t>();
  leaves_in_view_.Reset({base_leaf.x(), base_leaf.y(), base_leaf.z()});
  for (int row = 0; row < view.rows(); row += kRayStrideTiles) {
    leaves_in_view_.StartRow();
    for (int column = 0; column < view.columns(); column += kRayStrideTiles) {
      const Eigen::Vector3f way = view.EndOfRay(column, row) - view.camera_world();
      const float length_m = way.norm();
      if (!(length_m > 0.0F)) continue;
      const Eigen::Vector3f beyond = way * (static_cast<float>(scale.truncation_m) / length_m);
      leaves_in_view_.InsertSegment(camera_leaves - base,
                                    camera_leaves - base + (way + beyond) / leaf_size_m);
    }
  }
  return leaves_in_view_.Sorted();
}

/// Fuses free space into the fresh layer where the map knows something; elsewhere it would say
/// nothing.
void VoxelChangeMapper::ClearLeaf(const ViewFreeSpace& view,
                                  LeafOrigin origin,
                                  SessionVolume* fresh) {
  const LeafView known = map_->background().FindLeaf(origin);
  if (!known) return;
  const VoxelScale& scale = map_->scale();
  const auto truncation_m = static_cast<float>(scale.truncation_m);
  const auto voxel_size_m = static_cast<float>(scale.voxel_size_m);
  // A frame stands for those that are not compared.
  const auto looks = static_cast<float>(parameters_.frames_per_comparison);
  LeafVoxels voxels;
  bool is_changed = false;
  for (std::size_t offset = 0; offset < kLeafVoxels; ++offset) {
    if (!IsSet(known.observed, offset)) continue;
    const Eigen::Vector3f center_world = voxel_size_m * VoxelIndexAt(origin, offset).cast<float>();
    if (!view.IsClear(center_world, truncation_m)) continue;
    if (!is_changed) CopyLeaf(fresh->FindLeaf(origin), &voxels);
    is_changed = true;
    const float depth_m = std::max(view.DepthOf(center_world), kNearestLookM);
    FuseFreeLook(looks / (depth_m * depth_m), offset, &voxels);
  }
  if (is_changed) fresh->StoreLeaf(origin, voxels);
}

/// Brings over from the fresh layer what the map does not know, what it knows less well, and what
/// has changed.
void VoxelChangeMapper::TakeOver(const std::vector<LeafOrigin>& origins,
                                 const SessionVolume& fresh) {
  std::map<LeafOrigin, LeafMask> changed;
  for (const VoxelChange& change :
       FindChanges(map_->background(), fresh, origins, map_->scale(), parameters_.change)) {
    for (const ChangedLeaf& leaf : change.leaves) {
      LeafMask& mask = changed[leaf.origin];
      for (std::size_t word = 0; word < mask.size(); ++word) mask[word] |= leaf.voxels[word];
    }
    Report(change);
  }
  for (const LeafOrigin& origin : origins) {
    const LeafView leaf = fresh.FindLeaf(origin);
    if (!leaf) continue;
    const auto mask = changed.find(origin);
    TakeOverLeaf(origin, leaf, mask == changed.end() ? LeafMask{} : mask->second);
  }
}

/// Whether the fresh layer knows a voxel better than the map does, and does not contradict it.
bool VoxelChangeMapper::IsKnownBetter(const LeafView& known,
                                      const LeafView& fresh,
                                      std::size_t offset) const {
  return fresh.voxels[offset].weight_units() > known.voxels[offset].weight_units() &&
         !(IsComparable(known, fresh, offset, parameters_.change) &&
           IsDifferent(known, fresh, offset, map_->scale(), parameters_.change));
}

void VoxelChangeMapper::TakeOverLeaf(LeafOrigin origin,
                                     const LeafView& fresh,
                                     const LeafMask& changed) {
  const LeafView known = map_->background().FindLeaf(origin);
  LeafVoxels voxels;
  CopyLeaf(known, &voxels);
  bool is_changed = false;
  for (std::size_t offset = 0; offset < kLeafVoxels; ++offset) {
    if (!IsSet(fresh.observed, offset)) continue;
    const bool is_known = known && IsSet(known.observed, offset);
    if (!IsSet(changed, offset) && is_known && !IsKnownBetter(known, fresh, offset)) continue;
    if (!IsFree(fresh.voxels[offset], map_->scale(), parameters_.change)) {
      TakeVoxel(fresh, offset, &voxels);
    } else if (IsSet(changed, offset) ||
               (is_known && !IsComparable(known, fresh, offset, parameters_.change))) {
      // What is free is not kept: a map holds the bands around its surfaces.
      ClearVoxel(offset, &voxels);
    } else {
      continue;
    }
    is_changed = true;
  }
  if (is_changed) map_->StoreBackgroundLeaf(origin, voxels);
}

/// Tells that the background has changed: where something was removed, added or replaced.
void VoxelChangeMapper::Report(const VoxelChange& change) {
  const double deciding = kDecidingShare * static_cast<double>(change.voxels);
  ObjectEvent event;
  event.type = EventType::kUpdated;
  event.reason = EventReason::kDisplaced;
  if (static_cast<double>(change.freed) >= deciding) {
    event.reason = EventReason::kSeenThrough;
  } else if (static_cast<double>(change.taken) >= deciding) {
    event.reason = EventReason::kNewSurface;
  }
  event.object = kBackgroundId;
  event.time = map_->now();
  event.revision = map_->revision();
  event.center_world = change.mean_voxel * map_->scale().voxel_size_m;
  map_->RecordEvent(event);
}

}  // namespace steadymap
