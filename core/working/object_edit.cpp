#include "core/working/object_edit.h"

#include "core/working/working_map.h"

namespace steadymap {

ObjectEdit::~ObjectEdit() {
  object_->UpdateSurface(changed_leaves_);
  if (is_changed_ && map_ != nullptr) map_->MarkChanged(object_);
}

void ObjectEdit::StoreLeaf(LeafOrigin origin, const LeafVoxels& voxels) {
  object_->MutableVolume().StoreLeaf(origin, voxels);
  MarkLeaves({&origin, 1});
}

void ObjectEdit::TakeVolume(const TrackedObject& other) {
  std::vector<LeafOrigin> leaves;
  const auto collect = [&leaves](LeafOrigin origin, const LeafView&) { leaves.push_back(origin); };
  object_->volume().ForEachLeaf(collect);
  other.volume().ForEachLeaf(collect);
  object_->TakeVolume(other);
  MarkLeaves(leaves);
  is_changed_ = true;
  // The surface was copied, too.
  changed_leaves_.clear();
}

void ObjectEdit::MarkLeaves(std::span<const LeafOrigin> leaves) {
  if (leaves.empty()) return;
  is_changed_ = true;
  changed_leaves_.insert(changed_leaves_.end(), leaves.begin(), leaves.end());
  if (map_ != nullptr) map_->MarkLeaves(*object_, leaves);
}

}  // namespace steadymap
