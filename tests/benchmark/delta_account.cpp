#include "tests/benchmark/delta_account.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include "core/volume/leaf_patch.h"
#include "core/volume/tsdf_codec.h"

namespace steadymap::benchmarks {
namespace {

// Two good observations from one metre.
constexpr float kYoungWeight = 2.0F;

constexpr double kCalmShare = 0.05;

}  // namespace

void DeltaBookkeeper::Book(const v1::WatchMapResponse& message, DeltaAccount* account) {
  double booked = 0.0;
  for (const v1::PackedLeaf& leaf : message.delta().leaves()) {
    const auto bytes = static_cast<double>(leaf.ByteSizeLong());
    (leaf.object_id() == 0 ? account->background_bytes : account->object_leaf_bytes) += bytes;
    booked += bytes;
    BookLeaf(leaf, account);
  }
  for (const v1::Object& object : message.delta().objects()) {
    const auto bytes = static_cast<double>(object.ByteSizeLong());
    account->object_state_bytes += bytes;
    booked += bytes;
    account->moved_objects += 1.0;
  }
  if (message.has_events()) {
    const auto bytes = static_cast<double>(message.events().ByteSizeLong());
    account->event_bytes += bytes;
    booked += bytes;
  }
  account->other_bytes += static_cast<double>(message.ByteSizeLong()) - booked;
}

void DeltaBookkeeper::BookLeaf(const v1::PackedLeaf& leaf, DeltaAccount* account) {
  LeafVoxels sent;
  if (const absl::Status status = UnpackLeaf(leaf.packed(), &sent); !status.ok()) {
    throw std::runtime_error(status.ToString());
  }
  const LeafName name{leaf.object_id(), {leaf.origin_x(), leaf.origin_y(), leaf.origin_z()}};
  LeafVoxels& before = leaves_[name];
  LeafVoxels now = sent;
  if (leaf.is_patch()) {
    now = before;
    ApplyLeafPatch(sent, &now);
    account->patches += 1.0;
  }
  account->whole_bytes += static_cast<double>(leaf.ByteSizeLong() - leaf.packed().size() +
                                              PackLeaf(ViewOf(now)).size());
  double voxels = 0.0;
  double changed = 0.0;
  for (std::size_t i = 0; i < kLeafVoxels; ++i) {
    if (!IsSet(now.observed, i)) continue;
    voxels += 1.0;
    const double moved_m = std::abs(static_cast<double>(scale_.distance_m(now.voxels[i])) -
                                    static_cast<double>(scale_.distance_m(before.voxels[i])));
    const bool weighed = now.voxels[i].weight_units() != before.voxels[i].weight_units();
    const bool is_new = !IsSet(before.observed, i);
    if (!is_new && moved_m == 0.0 && !weighed) continue;
    changed += 1.0;
    if (is_new) {
      account->new_voxels += 1.0;
    } else if (moved_m == 0.0) {
      account->weighed_voxels += 1.0;
    } else {
      account->moved_voxels += 1.0;
      account->moved_m += moved_m;
      if (before.voxels[i].weight() < kYoungWeight) account->young_voxels += 1.0;
    }
  }
  account->leaves += 1.0;
  account->voxels += voxels;
  if (changed <= kCalmShare * voxels) account->calm_leaves += 1.0;
  before = now;
}

}  // namespace steadymap::benchmarks
