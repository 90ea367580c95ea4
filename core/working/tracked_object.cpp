#include "core/working/tracked_object.h"

#include <vector>

namespace steadymap {
namespace {

// A label that is wrong by a pixel at the border of an object, or a ray at a flat angle, such as to
// the floor at its foot, puts voxels beside the object: within two voxels, and few beside those of
// a face.
constexpr double kMaxShareBeyond = 0.1;
constexpr double kMaxVoxelsBeyond = 2.0;

Cuboid CuboidOf(const Box& box_world) {
  if (box_world.isEmpty()) return {};
  return {box_world.center(), box_world.sizes(), 0.0};
}

}  // namespace

TrackedObject::TrackedObject(ObjectId id,
                             const Eigen::Vector3d& position_world,
                             const VoxelScale& scale)
    : scale_(scale), volume_(std::make_shared<TsdfGrid>()) {
  state_.id = id;
  state_.T_world_object.position_world = position_world;
}

TrackedObject::TrackedObject(const MapObject& published, const VoxelScale& scale)
    : state_(static_cast<const ObjectState&>(published)),
      scale_(scale),
      // Shared until the first write, as after `Publish`.
      volume_(std::const_pointer_cast<TsdfGrid>(published.volume)) {
  surface_.Rebuild(*volume_, scale_);
  UpdateBounds();
}

TsdfGrid& TrackedObject::MutableVolume() {
  if (volume_.use_count() > 1) volume_ = volume_->Clone();
  return *volume_;
}

void TrackedObject::TakeVolume(const TrackedObject& other) {
  state_.T_world_object = other.state_.T_world_object;
  volume_ = other.volume_->Clone();
  surface_ = other.surface_;
  bounds_object_ = other.bounds_object_;
  cuboid_.reset();
}

void TrackedObject::UpdateSurface(std::span<const LeafOrigin> changed_leaves) {
  if (changed_leaves.empty()) return;
  surface_.Update(*volume_, scale_, changed_leaves);
  UpdateBounds();
}

void TrackedObject::UpdateBounds() {
  cuboid_.reset();
  Eigen::AlignedBox3f bounds;
  for (const SurfaceLeaf& leaf : surface_.leaves()) {
    for (const SurfaceVoxel& point : leaf.points) bounds.extend(point.position_object);
  }
  bounds_object_ = bounds.cast<double>();
}

double TrackedObject::SurfaceAreaM2() const {
  return static_cast<double>(surface_.point_count()) * scale_.voxel_size_m * scale_.voxel_size_m;
}

Box TrackedObject::BoundsInWorld() const {
  if (bounds_object_.isEmpty()) return {};
  const UprightPose& pose = state_.T_world_object;
  if (pose.yaw_rad == 0.0) return bounds_object_.translated(pose.position_world);
  const Eigen::Isometry3d T_world_object = pose.ToIsometry();
  const Eigen::Vector3d center_world = T_world_object * bounds_object_.center();
  const Eigen::Vector3d reach = T_world_object.linear().cwiseAbs() * (0.5 * bounds_object_.sizes());
  return {center_world - reach, center_world + reach};
}

std::vector<Eigen::Vector3d> TrackedObject::SurfaceInWorld() const {
  std::vector<Eigen::Vector3d> points_world;
  points_world.reserve(surface_.point_count());
  const Eigen::Isometry3d T_world_object = state_.T_world_object.ToIsometry();
  for (const SurfaceLeaf& leaf : surface_.leaves()) {
    for (const SurfaceVoxel& point : leaf.points) {
      points_world.emplace_back(T_world_object * point.position_object.cast<double>());
    }
  }
  return points_world;
}

const Cuboid& TrackedObject::cuboid() const {
  if (cuboid_.has_value() && cuboid_pose_ == state_.T_world_object) return *cuboid_;
  cuboid_pose_ = state_.T_world_object;
  const CuboidMargin margin = {kMaxShareBeyond, kMaxVoxelsBeyond * scale_.voxel_size_m};
  return cuboid_.emplace(FitCuboid(SurfaceInWorld(), margin));
}

std::shared_ptr<const MapObject> TrackedObject::Publish() const {
  auto published = std::make_shared<MapObject>(MapObject{state_, volume_});
  // Objects of an open session change with every frame, and few clients read their cuboids: their
  // bounds save a twelfth of the time of a frame.
  published->cuboid =
      state_.status == ObjectStatus::kTentative ? CuboidOf(BoundsInWorld()) : cuboid();
  return published;
}

}  // namespace steadymap
