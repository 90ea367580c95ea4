#include "core/policy/submap_change.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/association/class_votes.h"
#include "core/volume/tsdf_sample.h"
#include "core/working/object_split.h"

namespace steadymap {
namespace {

/// Around an object and as far beyond as its volume says anything, world frame.
Box ReachOf(const TrackedObject& object, double truncation_m) {
  return Grow(object.BoundsInWorld(), truncation_m);
}

}  // namespace

SubmapMapper::SubmapMapper(const MapConfig& config, const SubmapChangeParameters& parameters)
    : parameters_(parameters), segments_(config, parameters.segments) {}

void SubmapMapper::Process(const Frame& frame, SemanticCloud* cloud, WorkingMap* map) {
  map_ = map;
  std::vector<TrackedObject*> active;
  for (TrackedObject* object : segments_.Candidates(*cloud, map)) {
    if (IsActive(object->state())) active.push_back(object);
  }
  segments_.Match(active, cloud, map);
  segments_.AddObjects();
  segments_.Fuse();
  CountDetections();
  KeepOrMerge();
  if (map->revision().value() % parameters_.frames_per_test != 0) return;
  tiles_.Compute(frame.depth);
  TestInactive(ViewFreeSpace(*cloud, tiles_, parameters_.max_depth_m));
}

/// Counts the frame for the submaps that it detects, and against the other active ones.
void SubmapMapper::CountDetections() {
  std::set<ObjectId> detected;
  for (std::size_t place = 0; place < segments_.in_view().size(); ++place) {
    const std::size_t samples = segments_.CountSamples(place);
    if (samples == 0) continue;
    ObjectEdit edit = map_->Edit(segments_.in_view()[place].object);
    ObjectState& state = edit.state();
    ++state.supporting_frames;
    state.contradicted_updates = 0;
    state.last_seen = map_->now();
    AddVotes({{state.class_id, samples}}, &state);
    detected.insert(state.id);
  }
  for (TrackedObject* object : map_->AllObjects()) {
    if (!IsActive(object->state()) || detected.contains(object->id())) continue;
    ObjectEdit edit = map_->Edit(object);
    ++edit.state().contradicted_updates;
  }
}

/// Makes a submap that was detected often enough part of the map, or of the inactive submap that it
/// turns out to be; forgets one that was not.
void SubmapMapper::KeepOrMerge() {
  for (TrackedObject* object : map_->TentativeObjects()) {
    const ObjectState& state = object->state();
    if (!IsActive(state)) {
      map_->Delete(object);
    } else if (state.supporting_frames >= parameters_.keeping_views) {
      TrackedObject* twin = FindInactiveTwin(*object);
      if (twin != nullptr) {
        Reactivate(twin, object);
      } else {
        ObjectEdit edit = map_->Edit(object);
        edit.state().status = ObjectStatus::kPresent;
        map_->RecordEvent(map_->MakeEvent(EventType::kCreated, EventReason::kNewSurface, *object));
      }
    }
  }
}

/// The inactive submap of the same class on whose surface `fresh` lies; the oldest if several, null
/// if none.
TrackedObject* SubmapMapper::FindInactiveTwin(const TrackedObject& fresh) {
  const double truncation_m = map_->scale().truncation_m;
  const Box reach = ReachOf(fresh, truncation_m);
  for (TrackedObject* object : map_->ObjectsNear(Grow(reach, truncation_m))) {
    const ObjectState& state = object->state();
    if (!IsDormant(state) || state.class_id != fresh.state().class_id ||
        !reach.intersects(ReachOf(*object, truncation_m))) {
      continue;
    }
    if (IsMatch(Compare(fresh, *object))) return object;
  }
  return nullptr;
}

void SubmapMapper::Reactivate(TrackedObject* twin, TrackedObject* fresh) {
  const bool is_back = twin->is_archived();
  {
    ObjectEdit edit = map_->Edit(twin);
    CopyVoxels(*fresh, map_->scale(), &edit);
    ObjectState& state = edit.state();
    state.supporting_frames += fresh->state().supporting_frames;
    state.contradicted_updates = 0;
    state.last_seen = fresh->state().last_seen;
    if (is_back) state.status = ObjectStatus::kPresent;
  }
  if (is_back) {
    map_->RecordEvent(map_->MakeEvent(EventType::kReturned, EventReason::kShapeMatched, *twin));
  }
  map_->Delete(fresh);
}

/// Tests inactive submaps near the camera against the active ones and against free space.
void SubmapMapper::TestInactive(const ViewFreeSpace& view) {
  const double truncation_m = map_->scale().truncation_m;
  const Eigen::Vector3d camera_world = view.camera_world().cast<double>();
  const Box near_camera =
      Grow(Box(camera_world, camera_world), parameters_.max_depth_m + truncation_m);
  for (TrackedObject* object : map_->ObjectsNear(near_camera)) {
    if (!IsDormant(object->state())) continue;
    const Box reach = ReachOf(*object, truncation_m);
    if (reach.isEmpty() || reach.exteriorDistance(camera_world) > parameters_.max_depth_m) continue;
    Tally tally;
    tally.contradicted = CountLookedThrough(*object, view);
    for (const TrackedObject* other : map_->ObjectsNear(Grow(reach, truncation_m))) {
      if (other->state().status != ObjectStatus::kPresent || !IsActive(other->state()) ||
          !reach.intersects(ReachOf(*other, truncation_m))) {
        continue;
      }
      const Tally more = Compare(*object, *other);
      tally.known += more.known;
      tally.matching += more.matching;
      tally.contradicted += more.contradicted;
    }
    Decide(tally, object);
  }
}

void SubmapMapper::Decide(const Tally& tally, TrackedObject* object) {
  const double least_conflict = std::max(
      parameters_.max_conflict_points,
      parameters_.max_conflict_share * static_cast<double>(object->surface().point_count()));
  const bool is_present = object->state().status == ObjectStatus::kPresent;
  ObjectEdit edit = map_->Edit(object);
  if (tally.contradicted > least_conflict) {
    if (!is_present) return;
    map_->RecordEvent(map_->MakeEvent(EventType::kRemoved, EventReason::kSeenThrough, *object));
    edit.state().status = ObjectStatus::kArchived;
  } else if (IsMatch(tally)) {
    if (is_present) return;
    map_->RecordEvent(map_->MakeEvent(EventType::kReturned, EventReason::kShapeMatched, *object));
    edit.state().status = ObjectStatus::kPresent;
  }
}

bool SubmapMapper::IsMatch(const Tally& tally) const {
  return tally.matching >= parameters_.min_match_points &&
         tally.matching >= parameters_.min_match_share * tally.known;
}

/// Holds the surface of `object` against the volume of `other`. Before another surface was free
/// space; what lies behind it, nobody saw, unless it should be the same surface.
SubmapMapper::Tally SubmapMapper::Compare(const TrackedObject& object,
                                          const TrackedObject& other) const {
  const double match_distance_m = parameters_.match_distance_voxels * map_->scale().voxel_size_m;
  const bool same_class = object.state().class_id == other.state().class_id;
  // Submaps are never moved or turned.
  const Eigen::Vector3d way =
      object.state().T_world_object.position_world - other.state().T_world_object.position_world;
  const Box reach = ReachOf(other, map_->scale().truncation_m)
                        .translated(-other.state().T_world_object.position_world);
  TsdfSampler sampler(other.volume(), map_->scale());
  Tally tally;
  for (const SurfaceLeaf& leaf : object.surface().leaves()) {
    for (const SurfaceVoxel& point : leaf.points) {
      const Eigen::Vector3d point_other = point.position_object.cast<double>() + way;
      if (!reach.contains(point_other)) continue;
      const DistanceSample sample = sampler.Sample(point_other);
      if (!sample.known) continue;
      const double weight = std::min(sample.weight / parameters_.full_weight, 1.0);
      tally.known += weight;
      if (std::abs(sample.distance_m) <= match_distance_m) {
        tally.matching += same_class ? weight : 0.0;
      } else if (sample.distance_m > 0.0 || same_class) {
        tally.contradicted += weight;
      }
    }
  }
  return tally;
}

double SubmapMapper::CountLookedThrough(const TrackedObject& object,
                                        const ViewFreeSpace& view) const {
  const Eigen::Isometry3f T_world_object = object.state().T_world_object.ToIsometry().cast<float>();
  double count = 0.0;
  for (const SurfaceLeaf& leaf : object.surface().leaves()) {
    for (const SurfaceVoxel& point : leaf.points) {
      const Eigen::Vector3f point_world = T_world_object * point.position_object;
      const Eigen::Vector3f normal_world = T_world_object.linear() * point.normal_object;
      if (normal_world.dot(point_world - view.camera_world()) > 0.0F) continue;
      const float margin_m = SeenThroughMargin(view.DepthOf(point_world));
      if (view.LooksThrough(point_world, margin_m)) count += 1.0;
    }
  }
  return count;
}

}  // namespace steadymap
