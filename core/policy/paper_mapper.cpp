#include "core/policy/paper_mapper.h"

#include <cmath>
#include <map>
#include <utility>

#include "core/association/class_votes.h"
#include "core/geometry/assignment.h"
#include "core/geometry/cuboid.h"
#include "core/volume/tsdf_raycast.h"
#include "core/volume/tsdf_sample.h"

namespace steadymap {

PaperMapper::PaperMapper(const MapConfig& config, const PaperParameters& parameters)
    : config_(config),
      parameters_(parameters),
      segments_(config,
                parameters.segments,
                [config, clusters = parameters.clusters](const SampleGrid& samples,
                                                         const Eigen::Vector3d& camera_world,
                                                         Association* association) {
                  return FindClusters(samples, config, camera_world, clusters, association);
                }) {}

void PaperMapper::Process(const Frame& /*frame*/, SemanticCloud* cloud, WorkingMap* map) {
  map_ = map;
  segments_.Part(segments_.Candidates(*cloud, map), cloud, map);
  Associate();
  for (std::size_t place = 0; place < segments_.in_view().size(); ++place) {
    TrackedObject* object = segments_.in_view()[place].object;
    if (segments_.CountSamples(place) > 0) {
      UpdateMatched(place, *cloud);
    } else if (IsExpectedInView(*object, *cloud)) {
      {
        ObjectEdit edit = map->Edit(object);
        ++edit.state().contradicted_updates;
      }
      Update(object, parameters_.stationarity.max_change_m);
    }
  }
  AddObjects();
  segments_.Fuse();
}

/// Matches observations with objects: registers the pairs within the gate, then assigns at the
/// least cost.
void PaperMapper::Associate() {
  const std::vector<ObjectInView>& in_view = segments_.in_view();
  const std::vector<Observation>& segments = segments_.segments();
  std::vector<std::vector<Eigen::Vector3d>> points_world;
  std::vector<Eigen::Vector3d> centers_world;
  points_world.reserve(segments.size());
  centers_world.reserve(segments.size());
  for (const Observation& segment : segments) {
    points_world.push_back(segments_.PointsOf(segment));
    centers_world.push_back(MajorAxisCuboid(points_world.back()).center_world);
  }
  std::vector<AssignmentPair> pairs;
  std::map<std::pair<std::size_t, std::size_t>, Eigen::Vector3d> shifts;  // By row and column.
  for (std::size_t column = 0; column < in_view.size(); ++column) {
    const TrackedObject& object = *in_view[column].object;
    std::optional<IcpTarget> target;
    for (std::size_t row = 0; row < segments.size(); ++row) {
      const double apart_m = (object.cuboid().center_world - centers_world[row]).norm();
      if (apart_m > parameters_.association_distance_m) continue;
      if (!target.has_value()) target.emplace(object, parameters_.icp);
      const IcpFit fit = target->Align(points_world[row]);
      if (fit.outlier_share > parameters_.max_dissimilarity) continue;
      const bool is_other_class = object.state().class_id.value() != segments[row].label;
      shifts[{row, column}] = fit.shift_world;
      pairs.push_back({row,
                       column,
                       parameters_.position_weight * fit.shift_world.norm() +
                           parameters_.orientation_weight * std::abs(fit.yaw_rad) +
                           parameters_.class_weight * (is_other_class ? 1.0 : 0.0)});
    }
  }
  const std::vector<std::optional<std::size_t>> matches =
      AssignColumns(segments.size(), in_view.size(), pairs, parameters_.cost_cutoff);
  shift_of_.assign(in_view.size(), Eigen::Vector3d::Zero());
  for (std::size_t row = 0; row < matches.size(); ++row) {
    if (matches[row]) shift_of_[*matches[row]] = shifts.at({row, *matches[row]});
  }
  segments_.SetMatches(matches);
}

/// Updates the belief of a matched object. Its observation is fused if it shows hardly any change.
void PaperMapper::UpdateMatched(std::size_t place, const SemanticCloud& cloud) {
  TrackedObject* object = segments_.in_view()[place].object;
  CountView(segments_.CountSamples(place), object);
  const std::optional<double> change_m = MeasureChange(place, cloud);
  if (!change_m.has_value()) return;
  Update(object, *change_m);
  const double max_fused_m = 0.5 * parameters_.stationarity.change_noise_m;
  if (std::abs(*change_m) > max_fused_m || object->is_deleted()) segments_.Discard(place);
}

/// The change between what was seen of an object and what is known of it: positive if the object
/// came nearer, so that the registration moved the observation away from the camera. None where
/// nothing can be compared.
std::optional<double> PaperMapper::MeasureChange(std::size_t place,
                                                 const SemanticCloud& cloud) const {
  const TrackedObject& object = *segments_.in_view()[place].object;
  const Eigen::Vector3d camera_world = cloud.T_world_camera().translation();
  const Eigen::Vector3d forward_world = cloud.T_world_camera().linear().col(2);
  const Eigen::Isometry3d T_object_world = object.state().T_world_object.ToIsometry().inverse();
  TsdfSampler sampler(object.volume(), map_->scale());
  ChangeSum sum(parameters_.change);
  for (const Eigen::Vector3d& point_world : segments_.PointsOf(place)) {
    const Eigen::Vector3d ray_world = (point_world - camera_world).normalized();
    const double depth_per_m = ray_world.dot(forward_world);
    const RayHit object_hit = CastRay(sampler,
                                      T_object_world * camera_world,
                                      T_object_world.linear() * ray_world,
                                      config_.max_depth_m / depth_per_m);
    if (!object_hit.hit) continue;
    sum.AddRay(object_hit.range_m * depth_per_m, forward_world.dot(point_world - camera_world));
  }
  const std::optional<double> magnitude_m = sum.Change();
  if (!magnitude_m.has_value()) return std::nullopt;
  return std::copysign(*magnitude_m, shift_of_[place].dot(forward_world));
}

/// Whether enough of an object's points lie in the frustum, occluded or not.
bool PaperMapper::IsExpectedInView(const TrackedObject& object, const SemanticCloud& cloud) const {
  const Eigen::Isometry3d T_camera_object =
      cloud.T_world_camera().inverse() * object.state().T_world_object.ToIsometry();
  const PinholeCamera& camera = cloud.camera();
  std::size_t visible = 0;
  for (const SurfaceLeaf& leaf : object.surface().leaves()) {
    for (const SurfaceVoxel& point : leaf.points) {
      const Eigen::Vector3d point_camera = T_camera_object * point.position_object.cast<double>();
      if (point_camera.z() <= 0.0 || point_camera.z() > config_.max_depth_m) continue;
      if (camera.Contains(camera.Project(point_camera))) ++visible;
    }
  }
  return visible > 0 &&
         static_cast<double>(visible) >=
             parameters_.min_visible_share * static_cast<double>(object.surface().point_count());
}

/// Counts the frame for an object that it shows with so many samples.
void PaperMapper::CountView(std::size_t samples, TrackedObject* object) {
  ObjectEdit edit = map_->Edit(object);
  ObjectState& state = edit.state();
  ++state.supporting_frames;
  state.last_seen = map_->now();
  AddVotes({{state.class_id, samples}}, &state);
}

/// Updates the belief by one measurement, and removes what is no longer believed.
void PaperMapper::Update(TrackedObject* object, double change_m) {
  const ObjectState& state = object->state();
  const Belief before = state.belief;
  {
    ObjectEdit edit = map_->Edit(object);
    edit.state().belief =
        UpdateStationarity(
            before, change_m, PriorOf(config_, state.class_id), parameters_.stationarity)
            .belief;
  }
  if (state.belief.stationarity() >= parameters_.min_stationarity) return;
  ObjectEvent event = map_->MakeEvent(EventType::kRemoved, EventReason::kSeenThrough, *object);
  event.before = before;
  map_->RecordEvent(event);
  map_->Delete(object);
}

void PaperMapper::AddObjects() {
  const std::size_t known = segments_.in_view().size();
  segments_.AddObjects();
  for (std::size_t place = known; place < segments_.in_view().size(); ++place) {
    TrackedObject* object = segments_.in_view()[place].object;
    {
      ObjectEdit edit = map_->Edit(object);
      edit.state().belief = InitialBelief(parameters_.initial_stationarity);
      edit.state().status = ObjectStatus::kPresent;
      edit.state().supporting_frames = 1;
    }
    map_->RecordEvent(map_->MakeEvent(EventType::kCreated, EventReason::kNewSurface, *object));
  }
}

}  // namespace steadymap
