#include "core/map_sampler.h"

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

/// What lies further than this from an object's surface is not known to its volume: a cell of
/// voxels may begin a voxel beyond the truncation.
double ReachM(const VoxelScale& scale) { return scale.truncation_m + scale.voxel_size_m; }

std::vector<Box> ReachOf(const std::vector<PlacedVolume>& objects, const VoxelScale& scale) {
  std::vector<Box> boxes;
  boxes.reserve(objects.size());
  for (const PlacedVolume& object : objects) boxes.push_back(BoundsOf(object, ReachM(scale)));
  return boxes;
}

/// Around all leaves of the background, to the tile.
Box BoundsOfTiles(const MapSnapshot& snapshot) {
  Box bounds;
  for (const auto& [origin, tile] : snapshot.background.tiles()) {
    const Eigen::Vector3d lowest(origin.x, origin.y, origin.z);
    bounds.extend(Eigen::Vector3d(snapshot.scale.voxel_size_m * lowest));
    bounds.extend(Eigen::Vector3d(snapshot.scale.voxel_size_m * (lowest.array() + kTileSide)));
  }
  return bounds;
}

/// Whether `a` answers rather than `b`.
bool IsNearer(const MapDistance& a, const MapDistance& b) {
  if (!a.sample.known || !b.sample.known) return a.sample.known;
  const double a_m = std::abs(a.sample.distance_m);
  const double b_m = std::abs(b.sample.distance_m);
  return a_m != b_m ? a_m < b_m : a.object < b.object;
}

}  // namespace

MapSampler::MapSampler(const MapSnapshot& snapshot, QueryWork work)
    : scale_(snapshot.scale),
      work_(std::move(work)),
      background_(snapshot.background, snapshot.scale),
      background_bounds_(BoundsOfTiles(snapshot)),
      objects_(ShownObjects(snapshot)),
      samplers_(objects_.size()),
      reach_(ReachOf(objects_, snapshot.scale)) {}

TsdfSampler& MapSampler::SamplerOf(std::size_t object) {
  std::unique_ptr<TsdfSampler>& sampler = samplers_[object];
  if (sampler == nullptr) {
    sampler = std::make_unique<TsdfSampler>(*objects_[object].voxels, scale_);
  }
  return *sampler;
}

MapDistance MapSampler::Sample(const Eigen::Vector3d& point_world) {
  work_.Take();
  MapDistance nearest{background_.Sample(point_world), kBackgroundId, ClassId()};
  reach_.VisitAt(point_world, [&](std::size_t i) {
    work_.Take();
    const PlacedVolume& object = objects_[i];
    if (DistanceTo(object.object->cuboid, point_world) > ReachM(scale_)) return;
    MapDistance candidate{SamplerOf(i).Sample(object.T_world_volume.inverse() * point_world),
                          object.id(),
                          object.class_id()};
    if (!IsNearer(candidate, nearest)) return;
    candidate.sample.gradient = object.T_world_volume.linear() * candidate.sample.gradient;
    nearest = candidate;
  });
  return nearest;
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

MapRayHit MapSampler::CastRay(const Eigen::Vector3d& origin_world,
                              const Eigen::Vector3d& unit_direction_world,
                              double max_range_m) {
  MapRayHit nearest;
  double limit_m = max_range_m;
  if (const std::optional<RaySpan> span =
          ClipRay(background_bounds_, origin_world, unit_direction_world, max_range_m)) {
    nearest.hit = CastWithin(*span, origin_world, unit_direction_world, &background_);
    if (nearest.hit.hit) limit_m = nearest.hit.range_m;
  }
  for (const BoxTree::Crossing& crossing :
       reach_.FindAlong(origin_world, unit_direction_world, limit_m)) {
    if (crossing.entry_m > limit_m) break;
    const PlacedVolume& object = objects_[crossing.box];
    const Eigen::Isometry3d T_volume_world = object.T_world_volume.inverse();
    RayHit hit = CastWithin({crossing.entry_m, std::min(crossing.exit_m, limit_m)},
                            T_volume_world * origin_world,
                            T_volume_world.linear() * unit_direction_world,
                            &SamplerOf(crossing.box));
    // The last step of a ray may end a little behind its limit.
    if (!hit.hit || (nearest.hit.hit && hit.range_m >= nearest.hit.range_m)) continue;
    hit.point_m = object.T_world_volume * hit.point_m;
    hit.normal = object.T_world_volume.linear() * hit.normal;
    nearest = {hit, object.id(), object.class_id()};
    limit_m = hit.range_m;
  }
  return nearest;
}

}  // namespace steadymap
