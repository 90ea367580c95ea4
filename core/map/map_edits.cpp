#include "core/map/map_edits.h"

#include <cassert>
#include <string>
#include <utility>

#include <absl/strings/str_cat.h>

#include "core/types/error.h"
#include "core/volume/leaf_patch.h"
#include "core/volume/tsdf_codec.h"

namespace steadymap {
namespace {

/// The initial volume of objects. Shared, since an empty volume takes 20 KB.
const std::shared_ptr<const TsdfGrid>& EmptyVolume() {
  static const auto* const volume =
      new std::shared_ptr<const TsdfGrid>(std::make_shared<const TsdfGrid>());
  return *volume;
}

absl::Status BadLeaf(const std::string& what) {
  return MakeError(absl::StatusCode::kDataLoss, reason::kChecksum, what);
}

}  // namespace

void MapEdits::RemoveObject(ObjectId id) {
  edits_.erase(id);
  snapshot_->objects.erase(id);
}

void MapEdits::SetState(const ObjectState& state) {
  assert(state.id != kBackgroundId);
  ObjectEdit* edit = Edit(state.id);
  if (edit == nullptr) {
    edit = &edits_[state.id];
    edit->object = std::make_shared<MapObject>();
    edit->object->volume = EmptyVolume();
  }
  static_cast<ObjectState&>(*edit->object) = state;
}

absl::Status MapEdits::StoreLeaf(const LeafKey& key, std::string_view packed) {
  // Returns before a tile is cloned or created if there is no leaf to remove.
  if (key.object == kBackgroundId && packed.empty() &&
      !snapshot_->background.FindLeaf(key.origin)) {
    return absl::OkStatus();
  }
  LeafVoxels voxels;
  absl::Status status = UnpackLeaf(packed, &voxels);
  if (!status.ok()) return status;
  TsdfGrid* const grid = MutableGrid(key);
  if (grid != nullptr) {
    grid->StoreLeaf(key.origin, voxels);
  } else if (!packed.empty()) {
    return BadLeaf(absl::StrCat("a leaf of object ", key.object.value(), ", which does not exist"));
  }
  return absl::OkStatus();
}

absl::Status MapEdits::PatchLeaf(const LeafKey& key, std::string_view packed) {
  if (packed.empty()) return BadLeaf("a patch without voxels");
  LeafVoxels patch;
  absl::Status status = UnpackLeaf(packed, &patch);
  if (!status.ok()) return status;
  const bool is_background = key.object == kBackgroundId;
  const bool may_be_there = !is_background || snapshot_->background.FindLeaf(key.origin);
  TsdfGrid* const grid = may_be_there ? MutableGrid(key) : nullptr;
  if (grid == nullptr || !grid->FindLeaf(key.origin)) {
    return BadLeaf(
        absl::StrCat("a patch of a leaf of object ", key.object.value(), " that does not exist"));
  }
  LeafVoxels leaf;
  grid->LoadLeaf(key.origin, &leaf);
  ApplyLeafPatch(patch, &leaf);
  grid->StoreLeaf(key.origin, leaf);
  return absl::OkStatus();
}

void MapEdits::Finish() {
  for (auto& [id, edit] : edits_) {
    if (edit.volume != nullptr) edit.object->volume = std::move(edit.volume);
    snapshot_->objects.insert_or_assign(id, std::move(edit.object));
  }
  edits_.clear();
}

MapEdits::ObjectEdit* MapEdits::Edit(ObjectId id) {
  if (const auto edit = edits_.find(id); edit != edits_.end()) return &edit->second;
  const auto known = snapshot_->objects.find(id);
  if (known == snapshot_->objects.end()) return nullptr;
  ObjectEdit& edit = edits_[id];
  edit.object = std::make_shared<MapObject>(*known->second);
  return &edit;
}

TsdfGrid* MapEdits::MutableVolume(ObjectId id) {
  ObjectEdit* const edit = Edit(id);
  if (edit == nullptr) return nullptr;
  if (edit->volume == nullptr) edit->volume = edit->object->volume->Clone();
  return edit->volume.get();
}

TsdfGrid* MapEdits::MutableGrid(const LeafKey& key) {
  if (key.object == kBackgroundId) return &snapshot_->background.MutableTile(key.origin);
  return MutableVolume(key.object);
}

}  // namespace steadymap
