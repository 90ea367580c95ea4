#include "server/watch/watch_step.h"

#include <algorithm>
#include <utility>

#include "core/volume/leaf_patch.h"

namespace steadymap {
namespace {

/// Builds the step of one watcher from the changes.
class DeltaStepBuilder {
 public:
  DeltaStepBuilder(const MapFilter& filter, const ShownObjects* shown, StepPlan* step)
      : filter_(filter), shown_(shown), step_(step) {}

  void Add(const ChangeList& changes) {
    auto leaf = changes.leaves.begin();
    for (; leaf != changes.leaves.end() && leaf->object == kBackgroundId; ++leaf) {
      AddBackgroundLeaf(leaf->origin);
    }
    // Merges the changed objects and the objects with changed leaves, each once, by ascending id.
    auto object = changes.objects.begin();
    while (object != changes.objects.end() || leaf != changes.leaves.end()) {
      const bool by_leaf = object == changes.objects.end() ||
                           (leaf != changes.leaves.end() && leaf->object < *object);
      const ObjectId id = by_leaf ? leaf->object : *object;
      const bool state_changed = object != changes.objects.end() && *object == id;
      const auto first_leaf = leaf;
      while (leaf != changes.leaves.end() && leaf->object == id) ++leaf;
      if (state_changed) ++object;
      AddObject(id, state_changed, {first_leaf, leaf});
    }
  }

  /// Objects that the filter no longer shows, by ascending id.
  const std::vector<ObjectId>& left() const { return left_; }

 private:
  using Leaves =
      std::pair<std::vector<LeafKey>::const_iterator, std::vector<LeafKey>::const_iterator>;

  void AddBackgroundLeaf(LeafOrigin origin) {
    if (filter_.volumes && filter_.ShowsBackgroundLeaf(origin, step_->snapshot->scale)) {
      step_->leaves.push_back({kBackgroundId, origin});
    }
  }

  void AddObject(ObjectId id, bool state_changed, const Leaves& leaves) {
    const auto found = step_->snapshot->objects.find(id);
    const MapObject* object =
        found == step_->snapshot->objects.end() ? nullptr : found->second.get();
    const bool shows = object != nullptr && filter_.Shows(*object);
    const bool showed = shown_ != nullptr && std::binary_search(shown_->begin(), shown_->end(), id);
    if (shown_ == nullptr || (showed && !shows)) step_->removed.push_back(id);
    if (showed && !shows) left_.push_back(id);
    if (!shows) return;
    if (showed) {
      if (state_changed) step_->objects.push_back(id);
      if (filter_.volumes) step_->leaves.insert(step_->leaves.end(), leaves.first, leaves.second);
      return;
    }
    step_->joined.push_back(id);
    step_->objects.push_back(id);
    AddAllLeaves(*object);
  }

  void AddAllLeaves(const MapObject& object) {
    if (!filter_.volumes) return;
    object.volume->ForEachLeaf([&](LeafOrigin origin, const LeafView&) {
      step_->leaves.push_back({object.id, origin});
    });
  }

  const MapFilter& filter_;
  const ShownObjects* const shown_;
  StepPlan* const step_;
  std::vector<ObjectId> left_;
};

}  // namespace

std::optional<LeafView> StepPlan::FindPatch(const LeafKey& key) const {
  if (base == nullptr || std::binary_search(joined.begin(), joined.end(), key.object)) {
    return std::nullopt;
  }
  return FindLeafPatch(FindLeaf(*base, key), FindLeaf(*snapshot, key));
}

StepPlan MakeSnapshotStep(const MapFilter& filter,
                          std::shared_ptr<const MapSnapshot> snapshot,
                          const Cancellation& cancellation) {
  StepPlan step;
  step.shown = ShownBy(filter, *snapshot);
  step.snapshot = std::move(snapshot);
  if (filter.WantsObjects()) step.objects = *step.shown;
  if (!filter.volumes) return step;
  if (filter.ShowsBackground()) {
    step.snapshot->background.VisitLeaves([&](LeafOrigin origin, const LeafView&) {
      if (filter.ShowsBackgroundLeaf(origin, step.snapshot->scale)) {
        step.leaves.push_back({kBackgroundId, origin});
      }
      return !cancellation.IsCancelled();
    });
  }
  for (const ObjectId id : step.objects) {
    step.snapshot->objects.at(id)->volume->VisitLeaves([&](LeafOrigin origin, const LeafView&) {
      step.leaves.push_back({id, origin});
      return !cancellation.IsCancelled();
    });
    if (cancellation.IsCancelled()) return step;
  }
  std::sort(step.leaves.begin(), step.leaves.end());
  return step;
}

StepPlan MakeDeltaStep(const MapFilter& filter,
                       const ChangeList& changes,
                       Revision from,
                       const std::shared_ptr<const ShownObjects>& shown,
                       std::shared_ptr<const MapSnapshot> snapshot) {
  StepPlan step;
  step.from = from;
  step.commits = changes.commits;
  step.snapshot = std::move(snapshot);
  if (!filter.WantsObjects()) {
    step.shown = ShownBy(filter, *step.snapshot);
    return step;
  }
  DeltaStepBuilder builder(filter, shown.get(), &step);
  builder.Add(changes);
  std::sort(step.leaves.begin(), step.leaves.end());
  if (shown == nullptr) {
    step.shown = ShownBy(filter, *step.snapshot);
  } else if (step.joined.empty() && builder.left().empty()) {
    step.shown = shown;
  } else {
    ShownObjects kept;
    std::set_difference(shown->begin(),
                        shown->end(),
                        builder.left().begin(),
                        builder.left().end(),
                        std::back_inserter(kept));
    auto now = std::make_shared<ShownObjects>();
    std::merge(
        kept.begin(), kept.end(), step.joined.begin(), step.joined.end(), std::back_inserter(*now));
    step.shown = std::move(now);
  }
  return step;
}

std::shared_ptr<const ShownObjects> ShownBy(const MapFilter& filter, const MapSnapshot& snapshot) {
  auto shown = std::make_shared<ShownObjects>();
  if (!filter.WantsObjects()) return shown;
  for (const auto& [id, object] : snapshot.objects) {
    if (filter.Shows(*object)) shown->push_back(id);
  }
  return shown;
}

}  // namespace steadymap
