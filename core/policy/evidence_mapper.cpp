#include "core/policy/evidence_mapper.h"

#include <algorithm>
#include <cmath>

#include "core/association/cell_ownership.h"
#include "core/association/class_votes.h"
#include "core/change/free_space_carving.h"
#include "core/volume/tsdf_sample.h"
#include "core/working/object_split.h"

namespace steadymap {
namespace {

// The normals of a sample and of the surface that it is on differ by at most 45 degrees.
constexpr double kMinNormalCosine = 0.7;

bool IsInSession(const TrackedObject& object) {
  return object.state().status == ObjectStatus::kTentative;
}

}  // namespace

EvidenceMapper::EvidenceMapper(const MapConfig& config, const EvidenceMapperParameters& parameters)
    : config_(config),
      parameters_(parameters),
      moving_(config, parameters.moving),
      integrator_(config) {}

void EvidenceMapper::Process(const Frame& frame, SemanticCloud* cloud, WorkingMap* map) {
  map_ = map;
  cloud_ = cloud;
  moving_.Apply(frame.source, *map, cloud);
  samples_.Compute(*cloud);
  tiles_.Compute(frame.depth);
  moving_.Record(frame.source, *cloud, map);
  in_view_ = FindObjectsInView(map->ObjectsNear(ReachOfView(*cloud, config_.max_depth_m)),
                               *cloud,
                               samples_,
                               config_.max_depth_m);
  LookAtObjects();
  FindSurfaces();
  segments_ = FindFrameSegments(*cloud, samples_, is_mislabelled_, parameters_.continuity);
  AssignSegments();
  FuseSession();
  CarveFreeSpace(samples_, cloud->T_world_camera().translation(), map);
}

void EvidenceMapper::EndSession(WorkingMap* map) {
  DecideSession(config_, parameters_.identity, map);
}

void EvidenceMapper::LookAtObjects() {
  for (const ObjectInView& view : in_view_) {
    ObjectEvidence evidence = view.object->state().evidence;
    if (!AddLook({*cloud_, samples_, tiles_},
                 parameters_.looks,
                 map_->scale(),
                 map_->now(),
                 *view.object,
                 &evidence)) {
      continue;
    }
    ObjectEdit edit = map_->Edit(view.object);
    edit.state().evidence = std::move(evidence);
  }
}

/// Returns how far a sample on a surface may be measured off it, metres.
double EvidenceMapper::LimitAt(float depth_m) const {
  const double sigma_m = std::hypot(cloud_->depth_noise().SigmaM(static_cast<double>(depth_m)),
                                    parameters_.looks.pose_sigma_m);
  return parameters_.looks.max_sigmas * sigma_m + 0.5 * map_->scale().voxel_size_m;
}

/// True if a sample is on the surface of a volume, by the distance sampled there and its normal in
/// the frame of the volume.
bool EvidenceMapper::IsOnSurface(const SurfaceSample& sample,
                                 const DistanceSample& distance,
                                 const Eigen::Vector3d& normal) const {
  if (!distance.known) return false;
  return std::abs(distance.distance_m) <= LimitAt(sample.depth_m) &&
         normal.dot(distance.gradient) >= kMinNormalCosine;
}

/// Finds the samples on the surface of one object.
void EvidenceMapper::FindSurfaceOf(std::size_t place) {
  const ObjectInView& view = in_view_[place];
  const TrackedObject& object = *view.object;
  const Eigen::Isometry3d T_object_world = object.state().T_world_object.ToIsometry().inverse();
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(map_->scale().truncation_m);
  const Box reach_object(object.bounds_object().min() - margin,
                         object.bounds_object().max() + margin);
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
      if (is_on_object) on_objects_.push_back({index, place});
    }
  }
}

/// Finds the samples on known surface of the session or of the background. A label that contradicts
/// the surface is wrong.
void EvidenceMapper::FindSurfaces() {
  on_objects_.clear();
  for (std::size_t place = 0; place < in_view_.size(); ++place) {
    if (IsInSession(*in_view_[place].object)) FindSurfaceOf(place);
  }
  is_mislabelled_.assign(samples_.size(), 0);
  TsdfSampler sampler(map_->background(), map_->scale());
  for (std::size_t index = 0; index < samples_.size(); ++index) {
    const SurfaceSample& sample = samples_[index];
    if (!sample.is_valid() || config_.IsInBackground(ClassId(sample.label))) continue;
    const bool is_on_background = IsOnSurface(sample,
                                              sampler.Sample(sample.position_world.cast<double>()),
                                              sample.normal_world.cast<double>());
    is_mislabelled_[index] = is_on_background ? 1 : 0;
  }
  for (const SampleOnObject& found : on_objects_) {
    const SurfaceSample& sample = samples_[found.sample];
    is_mislabelled_[found.sample] =
        config_.IsInBackground(ClassId(sample.label)) && sample.instance == 0 ? 1 : 0;
  }
}

/// Returns what segments and objects of the session have in common, the largest first.
std::vector<EvidenceMapper::Claim> EvidenceMapper::FindClaims() const {
  std::map<std::pair<std::size_t, std::size_t>, double> areas_m2;  // By place and segment.
  for (const SampleOnObject& found : on_objects_) {
    const std::size_t segment = segment_of_[found.sample];
    if (segment == 0) continue;
    areas_m2[{found.place, segment - 1}] += static_cast<double>(samples_[found.sample].area_m2);
  }
  std::vector<Claim> claims;
  for (const auto& [key, area_m2] : areas_m2) {
    const auto& [place, segment] = key;
    const double smaller_m2 =
        std::min(in_view_[place].object->SurfaceAreaM2(), segments_[segment].area_m2);
    claims.push_back({segment, place, area_m2, area_m2 / smaller_m2});
  }
  std::stable_sort(claims.begin(), claims.end(), [](const Claim& a, const Claim& b) {
    return a.area_m2 > b.area_m2;
  });
  return claims;
}

/// True if a segment shows the object of a claim.
bool EvidenceMapper::IsOfObject(const Claim& claim) const {
  const FrameSegment& segment = segments_[claim.segment];
  if (in_view_[claim.place].object->state().class_id.value() == segment.label) {
    return claim.share >= parameters_.min_common_share;
  }
  return claim.area_m2 >= parameters_.min_mislabelled_share * segment.area_m2;
}

void EvidenceMapper::AssignSegments() {
  association_.owner.assign(samples_.size(), Association::kNone);
  segment_of_.assign(samples_.size(), 0);
  owner_of_.assign(segments_.size(), 0);
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    const bool is_background =
        segments_[i].instance == 0 && config_.IsInBackground(ClassId(segments_[i].label));
    for (const std::size_t index : segments_[i].samples) {
      if (is_background) {
        association_.owner[index] = kBackgroundOwner;
      } else {
        segment_of_[index] = i + 1;
      }
    }
  }
  std::map<std::size_t, std::uint16_t> instance_of;  // Of the place of an object.
  for (const Claim& claim : FindClaims()) {
    const std::uint16_t instance = segments_[claim.segment].instance;
    if (in_view_[claim.place].object->is_archived() || !IsOfObject(claim)) continue;
    const auto [known, is_new] = instance_of.emplace(claim.place, instance);
    if (!is_new && instance != 0 && known->second != instance) continue;
    std::size_t& owner = owner_of_[claim.segment];
    if (owner == 0) {
      owner = claim.place + 1;
    } else if (in_view_[owner - 1].object->state().class_id ==
               in_view_[claim.place].object->state().class_id) {
      JoinTentative(claim.place, owner - 1);
    }
  }
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    if (segment_of_[segments_[i].samples.front()] == 0) continue;
    if (owner_of_[i] == 0) AddSegmentAsObject(i);
    if (owner_of_[i] == 0) continue;
    for (const std::size_t index : segments_[i].samples) {
      association_.owner[index] = static_cast<std::uint32_t>(owner_of_[i]);
    }
  }
}

/// Makes one object of two that a segment shows to be connected.
void EvidenceMapper::JoinTentative(std::size_t place, std::size_t into) {
  JoinSessionObjects(in_view_[place].object, in_view_[into].object, map_);
  std::replace(owner_of_.begin(), owner_of_.end(), place + 1, into + 1);
}

void EvidenceMapper::AddSegmentAsObject(std::size_t index) {
  const FrameSegment& segment = segments_[index];
  if (segment.area_m2 < parameters_.min_new_area_m2) return;
  Eigen::Vector3d mean_world = Eigen::Vector3d::Zero();
  for (const std::size_t sample : segment.samples) {
    mean_world += samples_[sample].position_world.cast<double>();
  }
  TrackedObject& object = map_->AddObject(mean_world / static_cast<double>(segment.samples.size()));
  ObjectEdit edit = map_->Edit(&object);
  edit.state().class_id = ClassId(segment.label);
  edit.state().belief = InitialBelief(parameters_.identity.initial_stationarity);
  in_view_.push_back({&object, 0, samples_.width(), 0, samples_.height()});
  owner_of_[index] = in_view_.size();
}

void EvidenceMapper::FuseSession() {
  GiveCellsToNearestPlanes(samples_, association_, cloud_);
  integrator_.SetFrame(*cloud_);
  map_->FuseBackground(&integrator_);
  std::vector<std::map<ClassId, std::size_t>> samples_by_class(in_view_.size());
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    if (owner_of_[i] == 0) continue;
    samples_by_class[owner_of_[i] - 1][ClassId(segments_[i].label)] += segments_[i].samples.size();
  }
  for (std::size_t place = 0; place < in_view_.size(); ++place) {
    TrackedObject* object = in_view_[place].object;
    if (samples_by_class[place].empty() || object->is_archived()) continue;
    map_->FuseObject(static_cast<std::uint32_t>(place + 1), object, &integrator_);
    if (object->surface().point_count() == 0) {
      map_->Delete(object);
      continue;
    }
    ObjectEdit edit = map_->Edit(object);
    ++edit.state().supporting_frames;
    edit.state().last_seen = map_->now();
    AddVotes(samples_by_class[place], &edit.state());
  }
}

}  // namespace steadymap
