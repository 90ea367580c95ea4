#include "core/policy/tracking.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "core/association/class_votes.h"
#include "core/volume/tsdf_sample.h"

namespace steadymap {
namespace {

/// The median distance of points from the surface of a volume, volume frame, metres; infinity where
/// the volume does not know half of them.
double MedianDistance(const std::vector<Eigen::Vector3d>& points_world,
                      const Eigen::Isometry3d& T_volume_world,
                      const VoxelReader& volume,
                      const VoxelScale& scale) {
  TsdfSampler sampler(volume, scale);
  std::vector<double> distances_m;
  distances_m.reserve(points_world.size());
  for (const Eigen::Vector3d& point_world : points_world) {
    double distance_m = std::numeric_limits<double>::infinity();
    const Eigen::Vector3d point = T_volume_world * point_world;
    // The rim of what was seen counts as known.
    if (!sampler.SampleDistance(point, &distance_m) && !sampler.SampleNearest(point, &distance_m)) {
      distance_m = std::numeric_limits<double>::infinity();
    }
    distances_m.push_back(std::abs(distance_m));
  }
  const auto middle = distances_m.begin() + static_cast<std::ptrdiff_t>(distances_m.size() / 2);
  std::nth_element(distances_m.begin(), middle, distances_m.end());
  return *middle;
}

}  // namespace

TrackingMapper::TrackingMapper(const MapConfig& config, const TrackingParameters& parameters)
    : parameters_(parameters), segments_(config, parameters.segments) {}

void TrackingMapper::Process(const Frame& /*frame*/, SemanticCloud* cloud, WorkingMap* map) {
  map_ = map;
  segments_.Match(segments_.Candidates(*cloud, map), cloud, map);
  for (std::size_t place = 0; place < segments_.in_view().size(); ++place) Follow(place);
  segments_.AddObjects();
  CountViews();
  segments_.Fuse();
  ConfirmAndForget();
}

/// Registers one object to what the frame shows of it.
void TrackingMapper::Follow(std::size_t place) {
  const std::vector<Eigen::Vector3d> points_world = segments_.PointsOf(place);
  if (points_world.size() < parameters_.min_samples) {
    segments_.Release(place);
    return;
  }
  TrackedObject* object = segments_.in_view()[place].object;
  const Registration registration = RegisterPoints(points_world,
                                                   object->volume(),
                                                   map_->scale(),
                                                   object->state().T_world_object,
                                                   parameters_.registration);
  if (IsLost(registration, points_world, *object)) {
    segments_.Release(place);
    Drop(object);
  } else {
    Move(registration, object);
  }
}

bool TrackingMapper::IsLost(const Registration& registration,
                            const std::vector<Eigen::Vector3d>& points_world,
                            const TrackedObject& object) const {
  if (registration.shift_world.norm() > parameters_.max_jump_m) return true;
  const Eigen::Isometry3d T_object_corrected =
      object.state().T_world_object.ToIsometry().inverse() * registration.T_correction;
  return MedianDistance(points_world, T_object_corrected, object.volume(), map_->scale()) >
         parameters_.max_residual_voxels * map_->scale().voxel_size_m;
}

/// Takes the object to where it was found, and tells so once it has come far enough.
void TrackingMapper::Move(const Registration& registration, TrackedObject* object) {
  const double step_m = registration.shift_world.norm();
  if (step_m == 0.0 && registration.yaw_rad == 0.0) {
    SetMoved(0.0, object);
    return;
  }
  // The correction moves the points to the object; the object goes the other way.
  const Eigen::Isometry3d T_world_found =
      registration.T_correction.inverse() * object->state().T_world_object.ToIsometry();
  const double moved_m = object->state().belief.change_mean_m + step_m;
  {
    ObjectEdit edit = map_->Edit(object);
    UprightPose& T_world_object = edit.state().T_world_object;
    T_world_object.position_world = T_world_found.translation();
    T_world_object.yaw_rad -= registration.yaw_rad;
    edit.state().belief.change_mean_m = moved_m;
  }
  if (moved_m < parameters_.reported_move_m || object->state().status != ObjectStatus::kPresent) {
    return;
  }
  ObjectEvent event = map_->MakeEvent(EventType::kMoved, EventReason::kDisplaced, *object);
  event.old_center_world = event.center_world + registration.shift_world * (moved_m / step_m);
  map_->RecordEvent(event);
  SetMoved(0.0, object);
}

void TrackingMapper::SetMoved(double moved_m, TrackedObject* object) {
  ObjectEdit edit = map_->Edit(object);
  edit.state().belief.change_mean_m = moved_m;
}

void TrackingMapper::Drop(TrackedObject* object) {
  if (object->state().status == ObjectStatus::kPresent) {
    map_->RecordEvent(map_->MakeEvent(EventType::kRemoved, EventReason::kDisplaced, *object));
  }
  ObjectEdit edit = map_->Edit(object);
  edit.state().status = ObjectStatus::kArchived;
}

void TrackingMapper::CountViews() {
  for (std::size_t place = 0; place < segments_.in_view().size(); ++place) {
    const std::size_t samples = segments_.CountSamples(place);
    if (samples == 0) continue;
    ObjectEdit edit = map_->Edit(segments_.in_view()[place].object);
    ObjectState& state = edit.state();
    ++state.supporting_frames;
    state.last_seen = map_->now();
    AddVotes({{state.class_id, samples}}, &state);
  }
}

void TrackingMapper::ConfirmAndForget() {
  for (TrackedObject* object : map_->TentativeObjects()) {
    const ObjectState& state = object->state();
    if (state.supporting_frames >= parameters_.confirming_views) {
      ObjectEdit edit = map_->Edit(object);
      edit.state().status = ObjectStatus::kPresent;
      map_->RecordEvent(map_->MakeEvent(EventType::kCreated, EventReason::kNewSurface, *object));
    } else if ((map_->now() - state.last_seen).seconds() > parameters_.tentative_age_s) {
      map_->Delete(object);
    }
  }
}

}  // namespace steadymap
