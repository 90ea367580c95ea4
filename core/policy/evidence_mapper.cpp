#include "core/policy/evidence_mapper.h"

#include <algorithm>
#include <cmath>

#include "core/association/cell_ownership.h"
#include "core/association/class_votes.h"
#include "core/association/gaps.h"
#include "core/change/free_space_carving.h"
#include "core/objects/gap_planes.h"
#include "core/objects/unsegmented_surface.h"
#include "core/volume/tsdf_sample.h"

namespace steadymap {
namespace {

// Samples at an edge may have no plane, and no owner.
constexpr int kMaxEdgeSamples = 3;

// Poses with a smaller error are exact: registration would not improve them.
constexpr double kExactPoseM = 1e-4;

std::vector<LeafEvidence> LooksOf(const SensorName& source,
                                  const std::vector<SessionLooks>& looks) {
  const auto found = std::find_if(looks.begin(), looks.end(), [&](const SessionLooks& entry) {
    return entry.source == source;
  });
  return found == looks.end() ? std::vector<LeafEvidence>() : found->leaves;
}

/// Adds the offset that the known objects show, after the registration of each frame, to the pose
/// error of a robot, with which its drive goes on. Afterwards it is the offset of the claimed
/// poses.
void AddToPoseError(PoseOffset* offset, RobotState* robot) {
  if (!robot->pose_error) return;
  const Eigen::Isometry3d T_world_claimed = robot->claimed.ToIsometry();
  robot->pose_error->Move(offset->ToIsometry(), T_world_claimed.translation());
  const Eigen::Isometry3d motion =
      robot->pose_error->Combined().Correct(T_world_claimed) * T_world_claimed.inverse();
  offset->shift_world = motion * offset->center_world - offset->center_world;
  offset->yaw_rad = YawOf(motion);
}

}  // namespace

EvidenceMapper::EvidenceMapper(const MapConfig& config,
                               const EvidenceMapperParameters& parameters,
                               StageObserver* stages)
    : config_(config),
      parameters_(parameters),
      stages_(stages),
      guard_(parameters.guard),
      poses_(parameters.poses),
      moving_(config, parameters.moving),
      integrator_(config) {}

void EvidenceMapper::Process(const Frame& frame, SemanticCloud* cloud, WorkingMap* map) {
  map_ = map;
  cloud_ = cloud;
  stages_.Enter(MapperStage::kGuard);
  moving_.Apply(frame.source, *map, cloud);
  samples_.Compute(*cloud);
  tiles_.Compute(frame.depth);
  const bool counts = guard_.Accept(frame, {*cloud, samples_, tiles_}, map);
  BeginSession(frame);
  if (!counts) return;
  stages_.Enter(MapperStage::kRegistration);
  if (parameters_.poses.sigma_m >= kExactPoseM) CorrectPose(frame);
  moving_.Record(frame.source, *cloud, map);
  stages_.Enter(MapperStage::kAssociation);
  FindObjects(frame.source);
  has_segments_ = !frame.labels.empty() || !frame.instances.empty();
  stages_.Enter(MapperStage::kLooks);
  LookAtObjects(frame);
  stages_.Enter(MapperStage::kSegments);
  FindSurfaces();
  segments_ = has_segments_ ? FindFrameSegments(*cloud, samples_, uses_, parameters_.continuity)
                            : FindScene();
  SegmentAssignment assignment(config_,
                               parameters_.assignment,
                               parameters_.identity,
                               {frame.source, *cloud, samples_, segments_, on_objects_, uses_},
                               &in_view_,
                               map);
  if (has_segments_) {
    assignment.AssignSegments();
  } else {
    assignment.AssignScene();
  }
  RecordGaps(assignment);
  stages_.Enter(MapperStage::kIntegration);
  FuseSession(assignment);
  stages_.Enter(MapperStage::kFreeSpace);
  CarveFreeSpace(samples_,
                 cloud_->T_world_camera().translation(),
                 *map->FindRobot(frame.source)->session_start,
                 map);
}

void EvidenceMapper::BeginSession(const Frame& frame) {
  const RobotState* known = map_->FindRobot(frame.source);
  RobotState robot = known == nullptr ? RobotState() : *known;
  robot.last_capture_time = frame.capture_time;
  if (!robot.session_start) robot.session_start = frame.capture_time;
  if (known == nullptr || robot != *known) map_->StoreRobot(frame.source, robot);
}

/// Registers the frame to the map.
void EvidenceMapper::CorrectPose(const Frame& frame) {
  RobotState robot = *map_->FindRobot(frame.source);
  if (robot.pose_error) {
    const Duration pause = frame.capture_time - robot.pose_error->time;
    if (std::abs(pause.seconds()) > parameters_.sessions.max_pause_s) robot.pose_error.reset();
  }
  FindObjects(frame.source);
  robot.pose_error =
      poses_.Update(robot.pose_error, frame.capture_time, {*cloud_, samples_, in_view_}, *map_);
  map_->StoreRobot(frame.source, robot);
  cloud_->SetPose(robot.pose_error->Combined().Correct(frame.T_world_camera));
  samples_.Compute(*cloud_);
}

/// Finds the objects that the frame may see.
void EvidenceMapper::FindObjects(const SensorName& source) {
  in_view_ = FindObjectsInView(map_->ObjectsNear(ReachOfView(*cloud_, config_.max_depth_m)),
                               *cloud_,
                               samples_,
                               config_.max_depth_m);
  // Another robot may be wrong about its pose.
  std::erase_if(in_view_, [&](const ObjectInView& view) {
    const ObjectState& state = view.object->state();
    return state.status == ObjectStatus::kTentative && !IsInSession(state, source);
  });
}

bool EvidenceMapper::IsSessionOver(const Frame& next, const WorkingMap& map) const {
  const RobotState* robot = map.FindRobot(next.source);
  if (robot == nullptr || !robot->session_start) return false;
  const Duration pause = next.capture_time - robot->last_capture_time;
  const Duration duration = next.capture_time - *robot->session_start;
  if (std::abs(pause.seconds()) > parameters_.sessions.max_pause_s ||
      duration.seconds() > parameters_.sessions.max_duration_s) {
    return true;
  }
  const std::vector<const TrackedObject*> objects = map.TentativeObjectsOf(next.source);
  return std::any_of(objects.begin(), objects.end(), [&](const TrackedObject* object) {
    return HasLeft(parameters_.looks, parameters_.sessions.max_pause_s, *object);
  });
}

void EvidenceMapper::EndSession(const SensorName& sensor, WorkingMap* map) {
  RobotState robot;
  if (const RobotState* known = map->FindRobot(sensor); known != nullptr) robot = *known;
  std::optional<PoseOffset> offset = DecideSession(config_, parameters_.identity, sensor, map);
  if (!robot.session_start) return;
  if (offset) {
    offset->time = robot.last_capture_time;
    AddToPoseError(&*offset, &robot);
  }
  robot.offset = offset;
  robot.session_start.reset();
  map->StoreRobot(sensor, robot);
}

void EvidenceMapper::LookAtObjects(const Frame& frame) {
  const SensorName& source = frame.source;
  LookParameters looks = parameters_.looks;
  for (const ObjectInView& view : in_view_) {
    const ObjectState& state = view.object->state();
    looks.labels_decide =
        parameters_.looks.labels_decide && !frame.labels.empty() && state.class_id != kNoClass;
    const bool is_of_session = state.status == ObjectStatus::kTentative;
    ObjectEvidence evidence = state.evidence;
    if (!is_of_session) evidence.leaves = LooksOf(source, state.looks);
    if (!AddLook({*cloud_, samples_, tiles_},
                 looks,
                 map_->scale(),
                 map_->now(),
                 *view.object,
                 &evidence)) {
      continue;
    }
    ObjectEdit edit = map_->Edit(view.object);
    if (is_of_session) {
      edit.state().evidence = std::move(evidence);
    } else {
      TakeLooks(source, &edit.state().looks);
      StoreLooks(source, std::move(evidence.leaves), &edit.state().looks);
    }
  }
}

/// Returns how far a sample on a surface may be measured off it, metres.
double EvidenceMapper::LimitAt(float depth_m) const {
  return LookLimitM(parameters_.looks, *cloud_, map_->scale(), depth_m);
}

/// True if a sample is on the surface of a volume, by the distance sampled there and its normal in
/// the frame of the volume.
bool EvidenceMapper::IsOnSurface(const SurfaceSample& sample,
                                 const DistanceSample& distance,
                                 const Eigen::Vector3d& normal) const {
  if (!distance.known) return false;
  return std::abs(distance.distance_m) <= LimitAt(sample.depth_m) &&
         normal.dot(distance.gradient) >= parameters_.looks.min_normal_cosine;
}

/// Finds the samples on the surface of one object.
void EvidenceMapper::FindSurfaceOf(std::size_t place) {
  const ObjectInView& view = in_view_[place];
  const TrackedObject& object = *view.object;
  const Eigen::Isometry3d T_object_world = object.state().T_world_object.ToIsometry().inverse();
  const Box reach_object = Grow(object.bounds_object(), map_->scale().truncation_m);
  TsdfSampler sampler(object.volume(), map_->scale());
  for (int row = view.first_row; row < view.end_row; ++row) {
    for (int column = view.first_column; column < view.end_column; ++column) {
      const std::size_t index = samples_.Index(column, row);
      const SurfaceSample& sample = samples_[index];
      if (!sample.is_valid()) continue;
      const Eigen::Vector3d point = T_object_world * sample.position_world.cast<double>();
      if (!reach_object.contains(point)) continue;
      const Eigen::Vector3d normal = T_object_world.linear() * sample.normal_world.cast<double>();
      const DistanceSample distance = sampler.Sample(point);
      // Few points of a thing of two voxels lie between eight observed voxels.
      double nearest_m = 0.0;
      const bool is_on_object = distance.known ? IsOnSurface(sample, distance, normal)
                                               : sampler.SampleNearest(point, &nearest_m) &&
                                                     std::abs(nearest_m) <= LimitAt(sample.depth_m);
      if (is_on_object) on_objects_.push_back({index, place, distance.known});
    }
  }
}

/// True if an object is a structure, of which frames without labels fuse only what is not known.
bool EvidenceMapper::IsStructureInView(const TrackedObject& object) const {
  return !has_segments_ && IsStructure(object, parameters_.identity.parts.scene);
}

/// Returns the weight with which the frame measures the surface at a sample.
double EvidenceMapper::WeightOf(std::size_t index) const {
  const auto columns = static_cast<std::size_t>(samples_.width());
  const int column = static_cast<int>(index % columns) * SampleGrid::kStrideCells;
  const int row = static_cast<int>(index / columns) * SampleGrid::kStrideCells;
  return static_cast<double>(cloud_->At(column, row).weight);
}

/// Finds the samples on known surface of the session, of structures or of the background. A label
/// that contradicts the surface is wrong. Background that only a few frames have measured does not
/// contradict a label: those frames may have had the wrong one.
void EvidenceMapper::FindSurfaces() {
  on_objects_.clear();
  for (std::size_t place = 0; place < in_view_.size(); ++place) {
    const TrackedObject& object = *in_view_[place].object;
    const bool is_of_session = object.state().status == ObjectStatus::kTentative;
    if (is_of_session ? HasGivenExtent(object.state()) && !IsUnsegmented(object)
                      : IsStructureInView(object)) {
      FindSurfaceOf(place);
    }
  }
  uses_.assign(samples_.size(), SampleUse::kSegment);
  const Eigen::Vector3d camera_world = cloud_->T_world_camera().translation();
  TsdfSampler sampler(map_->background(), map_->scale());
  const auto min_frames = static_cast<double>(parameters_.identity.parts.min_doubted_frames);
  for (std::size_t index = 0; index < samples_.size(); ++index) {
    const SurfaceSample& sample = samples_[index];
    if (!sample.is_valid() || (has_segments_ && IsLabelledBackground(config_, sample))) continue;
    const DistanceSample background = sampler.Sample(sample.position_world.cast<double>());
    const bool is_on_background =
        IsOnSurface(sample, background, sample.normal_world.cast<double>()) &&
        (!has_segments_ || background.weight >= min_frames * WeightOf(index));
    const Eigen::Vector3d to_camera =
        (camera_world - sample.position_world.cast<double>()).normalized();
    const bool is_flat = to_camera.dot(sample.normal_world.cast<double>()) <
                         parameters_.continuity.min_facing_cosine;
    if (is_on_background) {
      uses_[index] = SampleUse::kNone;
    } else if (has_segments_ && is_flat) {
      uses_[index] = SampleUse::kSurface;
    }
  }
  for (const SampleOnObject& found : on_objects_) {
    const SurfaceSample& sample = samples_[found.sample];
    if ((has_segments_ && IsLabelledBackground(config_, sample)) ||
        IsStructureInView(*in_view_[found.place].object)) {
      uses_[found.sample] = SampleUse::kNone;
    }
  }
}

/// Returns the surface of a frame without labels that is not on the background as one segment.
std::vector<FrameSegment> EvidenceMapper::FindScene() const {
  FrameSegment scene;
  for (std::size_t index = 0; index < samples_.size(); ++index) {
    if (!samples_[index].is_valid() || uses_[index] != SampleUse::kSegment) continue;
    scene.samples.push_back(index);
    scene.area_m2 += static_cast<double>(samples_[index].area_m2);
  }
  if (scene.samples.empty()) return {};
  return {scene};
}

/// Keeps the gaps beside objects of the session that the frame looks through.
void EvidenceMapper::RecordGaps(const SegmentAssignment& assignment) {
  const std::vector<std::uint32_t>& owner = assignment.association().owner;
  // At an edge, samples have no plane.
  const auto owner_from = [&](const Eigen::Vector2i& cell,
                              const Eigen::Vector2i& step) -> std::uint32_t {
    Eigen::Vector2i at = cell / SampleGrid::kStrideCells;
    for (int i = 0; i < kMaxEdgeSamples; ++i, at += step) {
      if (at.x() < 0 || at.y() < 0 || at.x() >= samples_.width() || at.y() >= samples_.height()) {
        break;
      }
      const std::uint32_t found = owner[samples_.Index(at.x(), at.y())];
      if (Association::IsObject(found)) return found;
    }
    return Association::kNone;
  };
  std::map<std::uint32_t, std::vector<GapInView>> by_owner;
  for (const GapInView& gap : FindGaps(*cloud_, parameters_.assignment.gaps)) {
    const Eigen::Vector2i step = (gap.end - gap.begin).cwiseMin(1);
    const std::uint32_t before = owner_from(gap.begin, -step);
    const std::uint32_t behind = owner_from(gap.end, step);
    if (!Association::IsObject(before) || !Association::IsObject(behind)) continue;
    by_owner[before].push_back(gap);
  }
  for (const auto& [place, gaps] : by_owner) {
    TrackedObject* object = in_view_[place - 1].object;
    if (object->state().status != ObjectStatus::kTentative) continue;
    ObjectEdit edit = map_->Edit(object);
    AddGaps(gaps, map_->scale().voxel_size_m, &edit.state().gaps);
  }
}

void EvidenceMapper::FuseSession(const SegmentAssignment& assignment) {
  const Association& association = assignment.association();
  GiveCellsToNearestPlanes(samples_, association, cloud_);
  integrator_.SetFrame(*cloud_);
  map_->FuseBackground(&integrator_);
  std::vector<std::map<ClassId, std::size_t>> samples_by_class(in_view_.size());
  std::vector<char> is_seen(in_view_.size(), 0);
  for (std::size_t index = 0; index < samples_.size(); ++index) {
    const std::uint32_t owner = association.owner[index];
    const std::size_t segment = assignment.segment_of()[index];
    if (!Association::IsObject(owner)) continue;
    is_seen[owner - 1] = 1;
    if (segment != 0) ++samples_by_class[owner - 1][ClassId(segments_[segment - 1].label)];
  }
  for (std::size_t place = 0; place < in_view_.size(); ++place) {
    TrackedObject* object = in_view_[place].object;
    if (is_seen[place] == 0 || object->is_archived()) continue;
    if (samples_by_class[place].empty() && !IsUnsegmented(*object)) continue;
    map_->FuseObject(static_cast<std::uint32_t>(place + 1), object, &integrator_);
    if (object->surface().point_count() == 0) {
      map_->Delete(object);
      continue;
    }
    ObjectEdit edit = map_->Edit(object);
    edit.state().last_seen = map_->now();
    if (samples_by_class[place].empty()) continue;
    ++edit.state().supporting_frames;
    AddVotes(samples_by_class[place], &edit.state());
  }
}

}  // namespace steadymap
