#include "core/working/working_map.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "core/types/parallel.h"
#include "core/volume/tsdf_codec.h"

namespace steadymap {
namespace {

// Rounding depends on the frame of the computation, so touching boxes may be slightly apart.
constexpr double kTouchM = 1e-3;

// Limits the memory if clients invent robot ids; larger than any fleet.
constexpr std::size_t kMaxRobots = 1000;

// Minimum number of leaves packed per core and task: about 50 us of work.
constexpr std::size_t kMinRangeLeaves = 32;

template <typename Value>
void SortUnique(std::vector<Value>* values) {
  std::sort(values->begin(), values->end());
  values->erase(std::unique(values->begin(), values->end()), values->end());
}

/// Adds an id to a set or removes it.
void Keep(ObjectId id, bool is_member, std::set<ObjectId>* ids) {
  if (is_member) {
    ids->insert(id);
  } else {
    ids->erase(id);
  }
}

}  // namespace

WorkingMap::WorkingMap(const MapConfig& config)
    : map_(VoxelScale{config.voxel_size_m, config.truncation_m}) {}

void WorkingMap::Restore(const MapSnapshot& snapshot) {
  assert(snapshot.scale == map_.scale && committed_ == map_.revision);
  map_ = snapshot;
  committed_ = snapshot.revision;
  objects_.clear();
  places_ = {};
  tentative_.clear();
  archived_.clear();
  for (const auto& [id, object] : snapshot.objects) {
    Register(objects_.try_emplace(id, *object, snapshot.scale).first->second);
  }
}

void WorkingMap::BeginFrame(Revision revision, Timestamp capture_time) {
  map_.revision = revision;
  map_.last_capture_time = capture_time;
  now_ = capture_time;
}

void WorkingMap::BeginSessionEnd(Revision revision, const SensorName& sensor) {
  map_.revision = revision;
  const RobotState* robot = FindRobot(sensor);
  now_ = robot == nullptr ? map_.last_capture_time : robot->last_capture_time;
}

void WorkingMap::AddClasses(Revision revision, const std::vector<SemanticClass>& classes) {
  map_.revision = revision;
  map_.added_classes.insert(map_.added_classes.end(), classes.begin(), classes.end());
}

void WorkingMap::EndFrame() {
  for (const ObjectId id : forgotten_) {
    objects_.erase(id);
    places_.Erase(id);
    tentative_.erase(id);
    archived_.erase(id);
  }
  forgotten_.clear();
  assert(IsRegistered());
}

std::vector<ObjectId> WorkingMap::IdsNear(const Box& box_world) const {
  if (box_world.isEmpty()) return {};
  return places_.Find(Grow(box_world, kTouchM));
}

std::vector<TrackedObject*> WorkingMap::ObjectsNear(const Box& box_world) {
  std::vector<TrackedObject*> objects;
  for (const ObjectId id : IdsNear(box_world)) objects.push_back(&objects_.at(id));
  return objects;
}

std::vector<const TrackedObject*> WorkingMap::ObjectsNear(const Box& box_world) const {
  std::vector<const TrackedObject*> objects;
  for (const ObjectId id : IdsNear(box_world)) objects.push_back(&objects_.at(id));
  return objects;
}

std::vector<TrackedObject*> WorkingMap::AllObjects() {
  std::vector<TrackedObject*> objects;
  objects.reserve(objects_.size());
  for (auto& [id, object] : objects_) objects.push_back(&object);
  return objects;
}

std::vector<TrackedObject*> WorkingMap::FindAll(const std::set<ObjectId>& ids) {
  std::vector<TrackedObject*> objects;
  objects.reserve(ids.size());
  for (const ObjectId id : ids) objects.push_back(&objects_.at(id));
  return objects;
}

std::vector<TrackedObject*> WorkingMap::TentativeObjectsOf(const SensorName& source) {
  std::vector<TrackedObject*> objects = TentativeObjects();
  std::erase_if(objects,
                [&](const TrackedObject* object) { return !IsInSession(object->state(), source); });
  return objects;
}

std::vector<const TrackedObject*> WorkingMap::TentativeObjectsOf(const SensorName& source) const {
  std::vector<const TrackedObject*> objects;
  for (const ObjectId id : tentative_) {
    const TrackedObject& object = objects_.at(id);
    if (IsInSession(object.state(), source)) objects.push_back(&object);
  }
  return objects;
}

/// Updates the index and the status sets for an object.
void WorkingMap::Register(const TrackedObject& object) {
  const ObjectStatus standing = object.state().status;
  places_.Update(object.id(), object.BoundsInWorld());
  Keep(object.id(), standing == ObjectStatus::kTentative, &tentative_);
  Keep(object.id(), standing == ObjectStatus::kArchived, &archived_);
}

/// True if the index and the status sets agree with all objects: a missing mark of a changed
/// position or status is an error.
bool WorkingMap::IsRegistered() const {
  const auto is_registered = [this](const auto& entry) {
    const auto& [id, object] = entry;
    const ObjectStatus standing = object.state().status;
    const Box bounds_world = object.BoundsInWorld();
    const Box place = places_.BoundsOf(id);
    return tentative_.contains(id) == (standing == ObjectStatus::kTentative) &&
           archived_.contains(id) == (standing == ObjectStatus::kArchived) &&
           (bounds_world.isEmpty() ? place.isEmpty() : place.isApprox(bounds_world, 0.0));
  };
  return std::all_of(objects_.begin(), objects_.end(), is_registered);
}

TrackedObject& WorkingMap::Insert(const Eigen::Vector3d& position_world) {
  map_.newest_object = map_.newest_object.Next();
  return objects_.try_emplace(map_.newest_object, map_.newest_object, position_world, map_.scale)
      .first->second;
}

TrackedObject& WorkingMap::AddObject(const Eigen::Vector3d& position_world) {
  const double leaf_size_m = map_.scale.leaf_size_m();
  const Eigen::Vector3d nearest_leaf = (position_world.array() / leaf_size_m).round();
  TrackedObject& object = Insert(nearest_leaf * leaf_size_m);
  object.state_.first_seen = now();
  object.state_.in_place_since = now();
  object.state_.last_seen = now();
  MarkChanged(&object);
  return object;
}

TrackedObject& WorkingMap::AddPart(const TrackedObject& whole) {
  TrackedObject& part = Insert(whole.state().T_world_object.position_world);
  const ObjectId id = part.id();
  part.state_ = whole.state();
  part.state_.id = id;
  part.state_.evidence = {};
  part.state_.looks.clear();
  part.state_.gaps.clear();
  part.state_.contradictions.clear();
  MarkChanged(&part);
  return part;
}

void WorkingMap::Delete(TrackedObject* object) {
  object->MarkDeleted();
  object->volume().ForEachLeaf([&](LeafOrigin origin, const LeafView&) {
    MarkLeaves(*object, {&origin, 1});
  });
  changed_objects_.insert(object->id());
  forgotten_.push_back(object->id());
  Register(*object);
}

ObjectEdit WorkingMap::Edit(TrackedObject* object) {
  assert(&objects_.at(object->id()) == object);
  return {object, this};
}

void WorkingMap::MarkChanged(TrackedObject* object) {
  object->state_.revision = revision();
  changed_objects_.insert(object->id());
  Register(*object);
}

void WorkingMap::MarkLeaves(const TrackedObject& object, std::span<const LeafOrigin> leaves) {
  for (const LeafOrigin& origin : leaves) changed_leaves_.push_back({object.id(), origin});
}

void WorkingMap::FuseBackground(TsdfIntegrator* integrator) {
  std::vector<LeafOrigin> changed;
  integrator->Integrate(&map_.background, &changed);
  for (const LeafOrigin& origin : changed) changed_leaves_.push_back({kBackgroundId, origin});
}

void WorkingMap::StoreBackgroundLeaf(LeafOrigin origin, const LeafVoxels& voxels) {
  map_.background.MutableTile(origin).StoreLeaf(origin, voxels);
  changed_leaves_.push_back({kBackgroundId, origin});
}

void WorkingMap::FuseObject(std::uint32_t owner,
                            TrackedObject* object,
                            TsdfIntegrator* integrator) {
  std::vector<LeafOrigin> changed;
  integrator->Integrate(
      owner, object->state().T_world_object.ToIsometry(), &object->MutableVolume(), &changed);
  ObjectEdit edit = Edit(object);
  edit.MarkLeaves(changed);
}

std::vector<TrackedObject*> WorkingMap::FuseTiles(
    const std::function<ObjectLeaf(LeafOrigin)>& place_of, TsdfIntegrator* integrator) {
  std::vector<LeafOrigin> changed;
  integrator->IntegrateWorld(
      [&place_of](LeafOrigin origin) {
        const ObjectLeaf place = place_of(origin);
        return LeafPlace{&place.object->MutableVolume(), place.origin};
      },
      &changed);
  std::map<ObjectId, std::vector<LeafOrigin>> changed_by_tile;
  for (const LeafOrigin& origin : changed) {
    const ObjectLeaf place = place_of(origin);
    changed_by_tile[place.object->id()].push_back(place.origin);
  }
  std::vector<TrackedObject*> tiles;
  for (const auto& [id, leaves] : changed_by_tile) {
    tiles.push_back(&objects_.at(id));
    ObjectEdit edit = Edit(tiles.back());
    edit.MarkLeaves(leaves);
  }
  return tiles;
}

std::size_t WorkingMap::surface_bytes() const {
  std::size_t bytes = 0;
  for (const auto& [id, object] : objects_) bytes += object.surface().memory_bytes();
  return bytes;
}

void WorkingMap::MarkFree(const Eigen::Vector3d& from_world,
                          const Eigen::Vector3d& to_world,
                          Timestamp session_start) {
  map_.free_space.MarkRay(from_world, to_world, {session_start, now_}, &changed_blocks_);
}

const RobotState* WorkingMap::FindRobot(const SensorName& sensor) const {
  const auto found = map_.robots.find(sensor);
  return found == map_.robots.end() ? nullptr : &found->second;
}

void WorkingMap::StoreRobot(const SensorName& sensor, const RobotState& state) {
  map_.robots[sensor] = state;
  changed_robots_.insert(sensor);
  if (map_.robots.size() <= kMaxRobots) return;
  const auto order_of = [&](const auto& robot) {
    return std::pair(robot.first == sensor, robot.second.last_capture_time);
  };
  const auto longest_ago =
      std::min_element(map_.robots.begin(), map_.robots.end(), [&](const auto& a, const auto& b) {
        return order_of(a) < order_of(b);
      });
  changed_robots_.insert(longest_ago->first);
  map_.robots.erase(longest_ago);
}

ObjectEvent WorkingMap::MakeRobotEvent(EventType type,
                                       EventReason reason,
                                       const SensorName& sensor) const {
  ObjectEvent event;
  event.type = type;
  event.reason = reason;
  event.time = now();
  event.revision = revision();
  event.source = sensor;
  return event;
}

ObjectEvent WorkingMap::MakeEvent(EventType type,
                                  EventReason reason,
                                  const TrackedObject& object) const {
  const ObjectState& state = object.state();
  ObjectEvent event;
  event.type = type;
  event.reason = reason;
  event.object = state.id;
  event.class_id = state.class_id;
  event.time = now();
  event.revision = revision();
  event.center_world = object.cuboid().center_world;
  event.before = state.belief;
  event.after = state.belief;
  event.supporting_frames = state.supporting_frames;
  event.contradicted_updates = state.contradicted_updates;
  return event;
}

void WorkingMap::CommitObjects(MapDelta* delta) {
  delta->objects.reserve(changed_objects_.size());
  for (const ObjectId id : changed_objects_) {
    const auto object = objects_.find(id);
    if (object == objects_.end()) {
      map_.objects.erase(id);
      delta->objects.push_back({id, std::nullopt});
    } else {
      std::shared_ptr<const MapObject> published = object->second.Publish();
      delta->objects.push_back({id, static_cast<const ObjectState&>(*published)});
      map_.objects.insert_or_assign(id, std::move(published));
    }
  }
  changed_objects_.clear();
}

void WorkingMap::CommitLeaves(MapDelta* delta) {
  SortUnique(&changed_leaves_);
  delta->leaves.resize(changed_leaves_.size());
  ParallelFor(changed_leaves_.size(), kMinRangeLeaves, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const LeafKey& key = changed_leaves_[i];
      const LeafView leaf = FindLeaf(map_, key);
      delta->leaves[i] = {key, leaf ? PackLeaf(leaf) : std::string()};
    }
  });
  changed_leaves_.clear();
}

void WorkingMap::CommitFreeSpace(MapDelta* delta) {
  SortUnique(&changed_blocks_);
  delta->free_blocks.reserve(changed_blocks_.size());
  for (const LeafOrigin& origin : changed_blocks_) {
    delta->free_blocks.push_back({origin, map_.free_space.FindBlock(origin)});
  }
  changed_blocks_.clear();
}

void WorkingMap::CommitRobots(MapDelta* delta) {
  for (const SensorName& sensor : changed_robots_) {
    const RobotState* state = FindRobot(sensor);
    delta->robots.push_back({sensor, state ? std::optional(*state) : std::nullopt});
  }
  changed_robots_.clear();
}

MapCommit WorkingMap::Commit() {
  MapCommit commit;
  commit.delta.from = committed_;
  commit.delta.to = map_.revision;
  commit.delta.last_capture_time = map_.last_capture_time;
  commit.delta.newest_object = map_.newest_object;
  commit.delta.added_classes = map_.added_classes;
  commit.delta.events = std::exchange(events_, {});
  map_.last_event = EventNumber(map_.last_event.value() + commit.delta.events.size());
  commit.delta.last_event = map_.last_event;
  CommitObjects(&commit.delta);
  CommitLeaves(&commit.delta);
  CommitFreeSpace(&commit.delta);
  CommitRobots(&commit.delta);
  committed_ = map_.revision;
  commit.snapshot = std::make_shared<const MapSnapshot>(map_);
  return commit;
}

}  // namespace steadymap
