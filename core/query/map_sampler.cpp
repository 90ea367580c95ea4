#include "core/query/map_sampler.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace steadymap {
namespace {

std::vector<PlacedVolume> ShownObjects(const MapSnapshot& snapshot) {
  std::vector<PlacedVolume> volumes = ShownVolumes(snapshot);
  volumes.erase(volumes.begin());
  return volumes;
}

/// Returns the maximum distance of observed voxels from the surface of an object: a cell of voxels
/// extends by up to one voxel beyond the truncation distance.
double ReachM(const VoxelScale& scale) { return scale.truncation_m + scale.voxel_size_m; }

std::vector<Box> ReachOf(const std::vector<PlacedVolume>& objects, const VoxelScale& scale) {
  std::vector<Box> boxes;
  boxes.reserve(objects.size());
  for (const PlacedVolume& object : objects) boxes.push_back(BoundsOf(object, ReachM(scale)));
  return boxes;
}

/// Returns a box around all leaves of the background, rounded to whole tiles.
Box BoundsOfTiles(const MapSnapshot& snapshot) {
  Box bounds;
  for (const auto& [origin, tile] : snapshot.background.tiles()) {
    const Eigen::Vector3d lowest(origin.x, origin.y, origin.z);
    bounds.extend(Eigen::Vector3d(snapshot.scale.voxel_size_m * lowest));
    bounds.extend(Eigen::Vector3d(snapshot.scale.voxel_size_m * (lowest.array() + kTileSide)));
  }
  return bounds;
}

/// True if `a` takes precedence over `b`: the known one, then the nearer surface, then the lower
/// id.
bool IsNearer(const MapDistance& a, const MapDistance& b) {
  if (!a.sample.known || !b.sample.known) return a.sample.known;
  const double a_m = std::abs(a.sample.distance_m);
  const double b_m = std::abs(b.sample.distance_m);
  return a_m != b_m ? a_m < b_m : a.object < b.object;
}

/// Returns the intervals of a ray within cuboids, by increasing start. `bounds` are boxes around
/// the cuboids.
std::vector<RaySpan> OccupiedSpans(const Eigen::Vector3d& origin_world,
                                   const Eigen::Vector3d& unit_direction_world,
                                   double max_range_m,
                                   const BoxTree& bounds,
                                   const std::vector<Cuboid>& cuboids) {
  std::vector<RaySpan> spans;
  for (const BoxTree::Crossing& crossing :
       bounds.FindAlong(origin_world, unit_direction_world, max_range_m)) {
    const Cuboid& cuboid = cuboids[crossing.box];
    const Eigen::Isometry3d T_cuboid_world = cuboid.T_world_cuboid().inverse();
    const std::optional<RaySpan> span = ClipRay(Box(-0.5 * cuboid.size_m, 0.5 * cuboid.size_m),
                                                T_cuboid_world * origin_world,
                                                T_cuboid_world.linear() * unit_direction_world,
                                                max_range_m);
    if (span) spans.push_back(*span);
  }
  std::sort(spans.begin(), spans.end(), [](const RaySpan& a, const RaySpan& b) {
    return a.enter_m < b.enter_m;
  });
  return spans;
}

}  // namespace

MapSampler::MapSampler(const MapSnapshot& snapshot, QueryWork work)
    : scale_(snapshot.scale),
      work_(std::move(work)),
      background_(snapshot.background, snapshot.scale),
      background_bounds_(BoundsOfTiles(snapshot)),
      objects_(ShownObjects(snapshot)),
      samplers_(objects_.size()),
      reach_(ReachOf(objects_, snapshot.scale)),
      snapshot_(snapshot),
      free_bounds_(snapshot.free_space.Bounds()) {}

TsdfSampler& MapSampler::SamplerOf(std::size_t object) {
  std::unique_ptr<TsdfSampler>& sampler = samplers_[object];
  if (sampler == nullptr) {
    sampler = std::make_unique<TsdfSampler>(*objects_[object].voxels, scale_);
  }
  return *sampler;
}

MapDistance MapSampler::SampleVolumes(const Eigen::Vector3d& point_world) {
  work_.Take();
  MapDistance nearest;
  nearest.sample = background_.Sample(point_world);
  bool is_behind = nearest.sample.known && nearest.sample.distance_m <= 0.0;
  reach_.VisitAt(point_world, [&](std::size_t i) {
    work_.Take();
    const PlacedVolume& object = objects_[i];
    if (DistanceTo(object.object->cuboid, point_world) > ReachM(scale_)) return;
    MapDistance candidate;
    candidate.sample = SamplerOf(i).Sample(object.T_world_volume.inverse() * point_world);
    candidate.object = object.id();
    candidate.class_id = object.class_id();
    is_behind = is_behind || (candidate.sample.known && candidate.sample.distance_m <= 0.0);
    if (!IsNearer(candidate, nearest)) return;
    candidate.sample.gradient = object.T_world_volume.linear() * candidate.sample.gradient;
    nearest = candidate;
  });
  if (nearest.sample.known) nearest.state = is_behind ? PointState::kSurface : PointState::kFree;
  return nearest;
}

const BoxTree& MapSampler::Occupied() {
  if (occupied_) return *occupied_;
  std::vector<Box> boxes;
  for (const auto& [id, object] : snapshot_.objects) {
    if (object->status == ObjectStatus::kArchived) continue;
    cuboids_.push_back(object->cuboid);
    boxes.push_back(BoundsOf(VolumeOf(*object), 0.0));
  }
  return occupied_.emplace(boxes);
}

MapDistance MapSampler::Sample(const Eigen::Vector3d& point_world) {
  MapDistance answer = SampleVolumes(point_world);
  // The bounds exclude points that are not finite or too far away for a cell index.
  if (answer.sample.known || !free_bounds_.contains(point_world)) return answer;
  if (!snapshot_.free_space.IsFree(point_world)) return answer;
  answer.state = PointState::kFree;
  Occupied().VisitAt(point_world, [&](std::size_t i) {
    work_.Take();
    if (DistanceTo(cuboids_[i], point_world) == 0.0) answer.state = PointState::kUnknown;
  });
  return answer;
}

RayHit MapSampler::CastWithin(const RaySpan& span,
                              const Eigen::Vector3d& origin,
                              const Eigen::Vector3d& unit_direction,
                              TsdfSampler* sampler) {
  RayHit hit = steadymap::CastRay(*sampler,
                                  origin + span.enter_m * unit_direction,
                                  unit_direction,
                                  span.leave_m - span.enter_m,
                                  &work_);
  if (hit.hit) hit.range_m += span.enter_m;
  return hit;
}

MapRayHit MapSampler::FindSurface(const Eigen::Vector3d& origin_world,
                                  const Eigen::Vector3d& unit_direction_world,
                                  double max_range_m) {
  MapRayHit nearest;
  double limit_m = max_range_m;
  if (const std::optional<RaySpan> span =
          ClipRay(background_bounds_, origin_world, unit_direction_world, max_range_m)) {
    nearest.hit = CastWithin(*span, origin_world, unit_direction_world, &background_);
    if (nearest.hit.hit) limit_m = nearest.hit.range_m;
  }
  const std::vector<BoxTree::Crossing> crossings =
      reach_.FindAlong(origin_world, unit_direction_world, limit_m);
  work_.Take(crossings.size());
  for (const BoxTree::Crossing& crossing : crossings) {
    if (crossing.entry_m > limit_m) break;
    const PlacedVolume& object = objects_[crossing.box];
    const Eigen::Isometry3d T_volume_world = object.T_world_volume.inverse();
    RayHit hit = CastWithin({crossing.entry_m, std::min(crossing.exit_m, limit_m)},
                            T_volume_world * origin_world,
                            T_volume_world.linear() * unit_direction_world,
                            &SamplerOf(crossing.box));
    // The last step of a ray may end slightly beyond its limit.
    if (!hit.hit || (nearest.hit.hit && hit.range_m >= nearest.hit.range_m)) continue;
    hit.point_m = object.T_world_volume * hit.point_m;
    hit.normal = object.T_world_volume.linear() * hit.normal;
    nearest.hit = hit;
    nearest.object = object.id();
    nearest.class_id = object.class_id();
    limit_m = hit.range_m;
  }
  return nearest;
}

double MapSampler::FreeUntil(const Eigen::Vector3d& origin_world,
                             const Eigen::Vector3d& unit_direction_world,
                             double limit_m) {
  const std::vector<RaySpan> occupied =
      OccupiedSpans(origin_world, unit_direction_world, limit_m, Occupied(), cuboids_);
  work_.Take(occupied.size());
  auto next = occupied.begin();
  double range_m = 0.0;
  while (range_m < limit_m && work_.Take()) {
    while (next != occupied.end() && next->leave_m <= range_m) ++next;
    const double end_m = next == occupied.end() ? limit_m : std::min(next->enter_m, limit_m);
    const Eigen::Vector3d point_world = origin_world + range_m * unit_direction_world;
    if (end_m > range_m && free_bounds_.contains(point_world)) {
      range_m +=
          snapshot_.free_space.FreeRun(point_world, unit_direction_world, end_m - range_m, &work_);
      if (range_m >= limit_m) break;
    }
    const Eigen::Vector3d next_world = origin_world + range_m * unit_direction_world;
    if (SampleVolumes(next_world).state != PointState::kFree) break;
    // Not more than a step: space within the sampled distance of a point is not necessarily
    // observed.
    range_m += kStepVoxels * scale_.voxel_size_m;
  }
  return std::min(range_m, limit_m);
}

MapRayHit MapSampler::CastRay(const Eigen::Vector3d& origin_world,
                              const Eigen::Vector3d& unit_direction_world,
                              double max_range_m) {
  MapRayHit answer = FindSurface(origin_world, unit_direction_world, max_range_m);
  const double limit_m = answer.hit.hit ? answer.hit.range_m : max_range_m;
  answer.free_until_m = FreeUntil(origin_world, unit_direction_world, limit_m);
  if (answer.hit.hit) {
    answer.state = PointState::kSurface;
  } else if (answer.free_until_m >= max_range_m) {
    answer.state = PointState::kFree;
  }
  return answer;
}

}  // namespace steadymap
