#include "core/objects/session_parts.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <vector>

#include "core/association/class_votes.h"
#include "core/change/surface_looks.h"
#include "core/objects/gap_division.h"
#include "core/objects/legs.h"
#include "core/objects/outline.h"
#include "core/objects/part_votes.h"
#include "core/objects/surface_overlap.h"
#include "core/objects/surface_parts.h"
#include "core/objects/unsegmented_surface.h"
#include "core/volume/tsdf_sample.h"
#include "core/working/object_split.h"

namespace steadymap {
namespace {

// Voxels of two objects that are closer than this, voxels, are the same.
constexpr double kSameLatticeVoxels = 0.1;

/// Returns the number of surface points of `a` closer than `distance_m` to the surface of `b`.
std::size_t CountContacts(const TrackedObject& a,
                          const TrackedObject& b,
                          double distance_m,
                          const VoxelScale& scale) {
  const Eigen::Isometry3d T_b_world = b.state().T_world_object.ToIsometry().inverse();
  TsdfSampler sampler(b.volume(), scale);
  std::size_t count = 0;
  for (const Eigen::Vector3d& point_world : a.SurfaceInWorld()) {
    double found_m = 0.0;
    if (sampler.SampleNearest(T_b_world * point_world, &found_m) &&
        std::abs(found_m) <= distance_m) {
      ++count;
    }
  }
  return count;
}

/// Returns the length of the side of an object's cuboid that is neither the longest nor the
/// shortest.
double WidthOf(const TrackedObject& object) {
  const Eigen::Vector3d& size_m = object.cuboid().size_m;
  return size_m.sum() - size_m.maxCoeff() - size_m.minCoeff();
}

/// True if most of an object is in a cuboid, or within `margin_m` of it.
bool IsInside(const TrackedObject& object, const Cuboid& cuboid, double margin_m) {
  const std::vector<Eigen::Vector3d> points_world = object.SurfaceInWorld();
  const auto inside =
      std::count_if(points_world.begin(), points_world.end(), [&](const Eigen::Vector3d& point) {
        return DistanceTo(cuboid, point) <= margin_m;
      });
  return 2 * inside > std::ssize(points_world);
}

/// The completion of the objects of one session.
class PartCompletion {
 public:
  PartCompletion(const SessionPartParameters& parameters, const SensorName& source, WorkingMap* map)
      : parameters_(parameters), source_(source), map_(map) {}

  void Run() {
    DivideScenes();
    const PartDecisions decisions = DivideAtGaps(parameters_, source_, map_);
    election_ =
        PartElection(map_->TentativeObjectsOf(source_), decisions, parameters_.shares.substantial);
    JoinParts();
    DropFragments();
    JoinLegs(parameters_, source_, map_);
    JoinPieces();
    AddUnsegmentedSurface(parameters_, source_, map_);
  }

 private:
  void DivideScenes();
  void JoinParts();
  void DropFragments();
  void JoinPieces();
  bool IsPieceOf(const TrackedObject& object, const TrackedObject& other) const;

  const SessionPartParameters& parameters_;
  const SensorName& source_;
  WorkingMap* map_;
  PartElection election_;
};

/// Makes objects of surface that frames without labels have shown.
void PartCompletion::DivideScenes() {
  for (TrackedObject* object : map_->TentativeObjectsOf(source_)) {
    if (HasGivenExtent(object->state())) continue;
    DivideScene(parameters_.scene, parameters_.surface, object, map_);
  }
}

/// Makes one object of those that most frames show connected.
void PartCompletion::JoinParts() {
  std::map<ObjectId, TrackedObject*> objects;
  for (TrackedObject* object : map_->TentativeObjectsOf(source_)) {
    objects.emplace(object->id(), object);
  }
  while (true) {
    const auto [whole, part] = election_.FindPair();
    if (part == ObjectId()) return;
    JoinSessionObjects(objects.at(part), objects.at(whole), map_);
    election_.Join(part, whole);
  }
}

/// Deletes what is too small, or was seen too rarely.
void PartCompletion::DropFragments() {
  for (TrackedObject* object : map_->TentativeObjectsOf(source_)) {
    if (IsUnsegmented(*object)) continue;
    const LookCount looks = CountLooks(*object);
    const std::uint64_t frames = object->state().supporting_frames;
    if (frames < parameters_.min_frames ||
        (looks.is_doubtful() && frames < parameters_.min_doubted_frames) ||
        IsTooSmall(*object, parameters_)) {
      map_->Delete(object);
    }
  }
}

/// True if the smaller object is a part of the larger one, or a wrong label on it.
bool PartCompletion::IsPieceOf(const TrackedObject& object, const TrackedObject& other) const {
  const bool is_of_one_class = IsOfOneClass(object, other);
  const bool are_apart = is_of_one_class && election_.AreApart(object.id(), other.id());
  if (!are_apart && IsPartOf(object, other, parameters_, *map_)) return true;
  const double voxel_m = map_->scale().voxel_size_m;
  // A hollow object occludes parts of its own inside.
  if (are_apart && !election_.IsGapSeen(object.id(), other.id()) &&
      IsInside(object, other.cuboid(), voxel_m)) {
    return true;
  }
  if (!Grow(object.BoundsInWorld(), parameters_.scene.near_voxels * voxel_m)
           .intersects(other.BoundsInWorld())) {
    return false;
  }
  const Eigen::Isometry3d T_other_object = other.state().T_world_object.ToIsometry().inverse() *
                                           object.state().T_world_object.ToIsometry();
  const SurfaceOverlap overlap =
      CompareSurfaces(object, other, T_other_object, parameters_.surface, map_->scale());
  // Two things cannot have one surface, even if frames show them apart, as they do where noise or a
  // wrong label divides a thing. Of two classes, that of the larger object is right.
  if (overlap.known_close_share() > parameters_.shares.majority) return true;
  // Of two instances without a class, frames alone tell whether they are one.
  const bool may_be_one =
      is_of_one_class && (object.state().class_id != kNoClass || !HasGivenExtent(object.state()));
  if (!may_be_one || are_apart) return false;
  return overlap.known_fit_share() > parameters_.shares.substantial &&
         AreInContact(object, other, parameters_, map_->scale());
}

void PartCompletion::JoinPieces() {
  std::vector<TrackedObject*> objects;
  for (TrackedObject* object : map_->TentativeObjectsOf(source_)) {
    if (!IsUnsegmented(*object)) objects.push_back(object);
  }
  std::stable_sort(objects.begin(), objects.end(), [](const auto* a, const auto* b) {
    return a->surface().point_count() > b->surface().point_count();
  });
  for (std::size_t i = 1; i < objects.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (objects[j]->is_archived() || !IsPieceOf(*objects[i], *objects[j])) continue;
      if (IsOfOneClass(*objects[i], *objects[j])) {
        JoinSessionObjects(objects[i], objects[j], map_);
        election_.Join(objects[i]->id(), objects[j]->id());
      } else {
        map_->Delete(objects[i]);
      }
      break;
    }
  }
}

}  // namespace

void CompleteSessionObjects(const SessionPartParameters& parameters,
                            const SensorName& source,
                            WorkingMap* map) {
  PartCompletion(parameters, source, map).Run();
}

void CutGoneCells(TrackedObject* object, WorkingMap* map) {
  if (CountLooks(*object).gone == 0) return;
  TrackedObject& part = map->AddPart(*object);
  {
    ObjectEdit edit = map->Edit(object);
    ObjectEdit part_edit = map->Edit(&part);
    MoveGoneVoxels({-1, -1}, &edit, &part_edit);
  }
  map->Delete(&part);
}

bool IsTooSmall(const TrackedObject& object, const SessionPartParameters& parameters) {
  if (object.SurfaceAreaM2() < parameters.min_area_m2 || object.surface().point_count() < 2) {
    return true;
  }
  if (HasGivenExtent(object.state())) return false;
  const std::vector<double> weights = SurfaceWeightsOf(object);
  const double point_m2 = object.SurfaceAreaM2() / static_cast<double>(weights.size());
  return std::accumulate(weights.begin(), weights.end(), 0.0) * point_m2 <
         parameters.scene.min_weighted_area_m2;
}

bool IsOfOneClass(const TrackedObject& a, const TrackedObject& b) {
  return a.state().class_id == b.state().class_id;
}

bool AreInContact(const TrackedObject& a,
                  const TrackedObject& b,
                  const SessionPartParameters& parameters,
                  const VoxelScale& scale) {
  const double distance_m = parameters.surface.contact_voxels * scale.voxel_size_m;
  return DistanceBetween(a.cuboid(), b.cuboid()) <= distance_m &&
         CountContacts(a, b, distance_m, scale) >= parameters.min_points;
}

bool IsFragmentOf(const TrackedObject& object,
                  const TrackedObject& other,
                  const SessionPartParameters& parameters) {
  if (!IsOfOneClass(object, other) || object.state().class_id == kNoClass) return false;
  return object.SurfaceAreaM2() < parameters.fragment_share * other.SurfaceAreaM2() &&
         DistanceBetween(object.cuboid(), other.cuboid()) <
             parameters.max_hidden_gap_share * other.cuboid().size_m.maxCoeff();
}

bool IsPartOf(const TrackedObject& object,
              const TrackedObject& other,
              const SessionPartParameters& parameters,
              const WorkingMap& map) {
  if (!IsOfOneClass(object, other) || object.state().class_id == kNoClass) return false;
  if (IsFragmentOf(object, other, parameters)) return true;
  if (IsInside(object, other.cuboid(), map.scale().voxel_size_m)) return true;
  const double max_gap_m =
      std::max(map.scale().voxel_size_m, parameters.max_hidden_gap_share * WidthOf(object));
  if (!Grow(object.BoundsInWorld(), max_gap_m).intersects(other.BoundsInWorld())) return false;
  return OutlineTest(map, {}).MayGoOnAs(
      OrientedSurfaceOf(object), OrientedSurfaceOf(other), max_gap_m);
}

void AddVoxels(const TrackedObject& from, WorkingMap* map, TrackedObject* into) {
  const VoxelScale& scale = map->scale();
  const UprightPose& pose = from.state().T_world_object;
  const Eigen::Vector3d voxels =
      (pose.position_world - into->state().T_world_object.position_world) / scale.voxel_size_m;
  const bool is_on_lattice =
      ShareLattice(from.state(), into->state()) &&
      (voxels.array() - voxels.array().round()).abs().maxCoeff() < kSameLatticeVoxels;
  ObjectEdit edit = map->Edit(into);
  if (is_on_lattice) {
    CopyVoxels(from, scale, &edit);
  } else {
    ResampleVoxels(from, pose.ToIsometry(), 1.0, scale, &edit);
  }
}

void JoinSessionObjects(TrackedObject* object, TrackedObject* into, WorkingMap* map) {
  AddVoxels(*object, map, into);
  {
    ObjectEdit edit = map->Edit(into);
    ObjectState& state = edit.state();
    state.first_seen = std::min(state.first_seen, object->state().first_seen);
    state.last_seen = std::max(state.last_seen, object->state().last_seen);
    state.supporting_frames = std::max(state.supporting_frames, object->state().supporting_frames);
    JoinVotes(object->state().votes, &state);
    state.has_given_extent = state.has_given_extent || object->state().has_given_extent;
  }
  map->Delete(object);
}

}  // namespace steadymap
