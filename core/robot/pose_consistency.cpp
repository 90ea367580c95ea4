#include "core/robot/pose_consistency.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/volume/tsdf_sample.h"

namespace steadymap {
namespace {

// Samples of a patch's side.
constexpr int kPatchSamples = 4;

// Every so many points of an object's surface are looked for in the picture.
constexpr std::size_t kPointStride = 3;

/// What is known of one patch.
struct Patch {
  Eigen::Vector3d position_world;  ///< Of its surface, laid into the map.
  Eigen::Vector3d normal_world;
  bool is_surface = false;
  bool is_steep = false;
  bool fits = false;
  bool is_in_front = false;  ///< Of a known surface, where nothing was.
  bool is_through = false;   ///< Whether something known was looked through.
};

/// A frame cut into patches and laid into a map.
class PatchGrid {
 public:
  PatchGrid(const PoseConsistencyParameters& parameters,
            const FrameSurface& frame,
            const Eigen::Isometry3d& T_world_camera)
      : parameters_(parameters),
        frame_(frame),
        T_world_camera_(T_world_camera),
        wide_(static_cast<std::size_t>(frame.samples.width() / kPatchSamples)),
        high_(static_cast<std::size_t>(frame.samples.height() / kPatchSamples)),
        patches_(wide_ * high_),
        reach_m_(static_cast<double>(frame.tiles.farthest_m())) {
    const Eigen::Isometry3d T_map_frame = T_world_camera * frame.cloud.T_world_camera().inverse();
    for (std::size_t index = 0; index < patches_.size(); ++index) {
      const auto column = static_cast<int>(index % wide_);
      const auto row = static_cast<int>(index / wide_);
      const SurfaceSample& sample = frame.samples.At(column * kPatchSamples + kPatchSamples / 2,
                                                     row * kPatchSamples + kPatchSamples / 2);
      if (!sample.is_valid()) continue;
      Patch& patch = patches_[index];
      patch.is_surface = true;
      patch.position_world = T_map_frame * sample.position_world.cast<double>();
      patch.normal_world = T_map_frame.linear() * sample.normal_world.cast<double>();
      // Steeper than 45 degrees.
      patch.is_steep = std::abs(patch.normal_world.z()) < M_SQRT1_2;
      reach_m_ = std::max(reach_m_, (patch.position_world - T_world_camera.translation()).norm());
    }
  }

  const std::vector<Patch>& patches() const { return patches_; }

  /// Where objects matter, world frame.
  Box Reach() const {
    const Eigen::Vector3d camera_world = T_world_camera_.translation();
    const Eigen::Vector3d reach_m = Eigen::Vector3d::Constant(reach_m_);
    return {camera_world - reach_m, camera_world + reach_m};
  }

  /// Which patches a volume knows, within bounds of its frame if there are any.
  void CompareVolume(const VoxelReader& volume,
                     const VoxelScale& scale,
                     const Eigen::Isometry3d& T_volume_world,
                     const Box* bounds) {
    TsdfSampler sampler(volume, scale);
    for (Patch& patch : patches_) {
      if (!patch.is_surface || patch.fits) continue;
      const Eigen::Vector3d position = T_volume_world * patch.position_world;
      if (bounds != nullptr && !bounds->contains(position)) continue;
      const DistanceSample known = sampler.Sample(position);
      if (!known.known) continue;
      const Eigen::Vector3d normal = T_volume_world.linear() * patch.normal_world;
      if (known.gradient.dot(normal) >= parameters_.min_normal_cosine) {
        patch.fits = true;
      } else if (known.distance_m > 0.0) {
        patch.is_in_front = true;
      }
    }
  }

  /// Which patches an object knows, and which look through it.
  void CompareObject(const TrackedObject& object, const VoxelScale& scale) {
    if (object.is_archived() || object.bounds_object().isEmpty()) return;
    const Eigen::Isometry3d T_world_object = object.state().T_world_object.ToIsometry();
    const Eigen::Isometry3d T_object_world = T_world_object.inverse();
    const Eigen::Vector3d camera_object = T_object_world * T_world_camera_.translation();
    if (object.bounds_object().exteriorDistance(camera_object) > reach_m_) return;
    Box bounds = object.bounds_object();
    bounds.min().array() -= scale.truncation_m;
    bounds.max().array() += scale.truncation_m;
    CompareVolume(object.volume(), scale, T_object_world, &bounds);
    const Eigen::Isometry3d T_camera_object = T_world_camera_.inverse() * T_world_object;
    LookThrough(object.surface(), T_camera_object.cast<float>());
  }

 private:
  void LookThrough(const ObjectSurface& surface, const Eigen::Isometry3f& T_camera_object) {
    const auto min_facing = static_cast<float>(parameters_.min_facing_cosine);
    std::size_t count = 0;
    for (const SurfaceLeaf& leaf : surface.leaves()) {
      for (const SurfaceVoxel& point : leaf.points) {
        if (count++ % kPointStride != 0) continue;
        const Eigen::Vector3f point_camera = T_camera_object * point.position_object;
        const Eigen::Vector3f normal_camera = T_camera_object.linear() * point.normal_object;
        if (point_camera.z() < MinDepthGrid::kNearestLookM ||
            -normal_camera.dot(point_camera) < min_facing * point_camera.norm()) {
          continue;
        }
        Patch* patch = PatchLookingThrough(point_camera);
        if (patch != nullptr) patch->is_through = true;
      }
    }
  }

  /// Returns the largest depth at which a surface may be measured, metres, if it is at `depth_m`
  /// seen from the right pose.
  float FarthestOf(float depth_m) const {
    const auto sigma_m =
        static_cast<float>(frame_.cloud.depth_noise().SigmaM(static_cast<double>(depth_m)));
    return depth_m + kSigmas * sigma_m + static_cast<float>(parameters_.through_m);
  }

  /// The patch in which depth was measured well behind a point; null if none was.
  Patch* PatchLookingThrough(const Eigen::Vector3f& point_camera) {
    const std::optional<SamplePlace> place =
        frame_.samples.FindPlace(frame_.cloud.camera(), point_camera);
    if (!place) return nullptr;
    const auto patch_column = static_cast<std::size_t>(place->column / kPatchSamples);
    const auto patch_row = static_cast<std::size_t>(place->row / kPatchSamples);
    if (patch_column >= wide_ || patch_row >= high_ ||
        frame_.tiles.NearestAround(place->column, place->row) <= FarthestOf(point_camera.z())) {
      return nullptr;
    }
    return &patches_[patch_row * wide_ + patch_column];
  }

  const PoseConsistencyParameters& parameters_;
  const FrameSurface& frame_;
  Eigen::Isometry3d T_world_camera_;
  std::size_t wide_;
  std::size_t high_;
  std::vector<Patch> patches_;
  double reach_m_;  ///< Nothing that is further away matters.
};

}  // namespace

PoseConsistency CompareFrame(const PoseConsistencyParameters& parameters,
                             const FrameSurface& frame,
                             const Eigen::Isometry3d& T_world_camera,
                             const WorkingMap& map) {
  PatchGrid grid(parameters, frame, T_world_camera);
  for (const TrackedObject* object : map.ObjectsNear(grid.Reach())) {
    grid.CompareObject(*object, map.scale());
  }
  grid.CompareVolume(map.background(), map.scale(), Eigen::Isometry3d::Identity(), nullptr);
  PoseConsistency agreement;
  agreement.patches = grid.patches().size();
  for (const Patch& patch : grid.patches()) {
    if (patch.fits) {
      agreement.fitting += patch.is_steep ? 1U : 0U;
    } else if (patch.is_through || patch.is_in_front ||
               (patch.is_surface && map.free_space().IsFree(patch.position_world))) {
      ++agreement.contradicting;
    } else if (patch.is_steep) {
      ++agreement.unknown;
    }
  }
  return agreement;
}

}  // namespace steadymap
