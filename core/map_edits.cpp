#include "core/map_edits.h"

#include <cassert>
#include <utility>

#include <absl/strings/str_cat.h>

#include "core/error.h"
#include "core/tsdf_codec.h"

namespace steadymap {
namespace {

/// What objects have before their first leaf. Shared, since an empty volume takes 20 KB.
const std::shared_ptr<const TsdfGrid>& EmptyVolume() {
  static const auto* const volume =
      new std::shared_ptr<const TsdfGrid>(std::make_shared<const TsdfGrid>());
  return *volume;
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
  const bool is_background = key.object == kBackgroundId;
  // Nothing is cloned only to find that there is nothing to remove.
  if (is_background && packed.empty() && !snapshot_->background.FindLeaf(key.origin)) {
    return absl::OkStatus();
  }
  LeafVoxels voxels;
  absl::Status status = UnpackLeaf(packed, snapshot_->scale, &voxels);
  if (!status.ok()) return status;
  TsdfGrid* volume =
      is_background ? &snapshot_->background.MutableTile(key.origin) : MutableVolume(key.object);
  if (volume != nullptr) {
    volume->StoreLeaf(key.origin, voxels);
  } else if (!packed.empty()) {
    return MakeError(absl::StatusCode::kDataLoss,
                     reason::kChecksum,
                     absl::StrCat("a leaf of object ", key.object.value(), ", which is not there"));
  }
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

}  // namespace steadymap
