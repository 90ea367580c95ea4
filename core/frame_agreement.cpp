#include "core/frame_agreement.h"

#include <cmath>
#include <cstdint>
#include <vector>

#include "core/tsdf_sample.h"

namespace steadymap {
namespace {

// Samples of a patch's side.
constexpr int kPatchSamples = 4;

// Surface is steep if its normal rises less than this.
constexpr float kSteep = 0.7F;

// Loose enough for a small error of the pose, tight enough that a wall is no wall at 40 degrees.
constexpr double kMinNormalCosine = 0.8;

// A view is through a surface if it ends so much further away.
constexpr float kThroughM = 0.25F;

// Every so many points of an object's surface are looked for in the picture.
constexpr std::size_t kPointStride = 3;

// Points seen flatter than this are not looked for.
constexpr float kMinFacing = 0.2F;

/// What is known of one patch.
struct Patch {
  Eigen::Vector3d position_world;  ///< Where the surface would be.
  Eigen::Vector3d normal_world;
  bool is_surface = false;
  bool is_steep = false;
  bool fits = false;
  bool is_in_front = false;  ///< Of a known surface, where nothing was.
  bool is_through = false;   ///< Whether something known was looked through.
};

/// The frame cut into patches and laid into the map.
class PatchGrid {
 public:
  PatchGrid(const FrameSurface& frame, const Eigen::Isometry3d& T_world_camera)
      : frame_(frame),
        T_camera_world_(T_world_camera.inverse().cast<float>()),
        wide_(frame.samples.width() / kPatchSamples),
        high_(frame.samples.height() / kPatchSamples) {
    const Eigen::Isometry3d T_here_there = T_world_camera * frame.cloud.T_world_camera().inverse();
    patches_.resize(static_cast<std::size_t>(wide_ * high_));
    for (int row = 0; row < high_; ++row) {
      for (int column = 0; column < wide_; ++column) {
        const SurfaceSample& sample = frame.samples.At(column * kPatchSamples + kPatchSamples / 2,
                                                       row * kPatchSamples + kPatchSamples / 2);
        if (!sample.is_valid()) continue;
        Patch& patch = At(column, row);
        patch.is_surface = true;
        patch.position_world = T_here_there * sample.position_world.cast<double>();
        patch.normal_world = T_here_there.linear() * sample.normal_world.cast<double>();
        patch.is_steep = std::abs(static_cast<float>(patch.normal_world.z())) < kSteep;
        bounds_world_.extend(patch.position_world);
      }
    }
  }

  const std::vector<Patch>& patches() const { return patches_; }

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
      if (known.gradient.dot(normal) >= kMinNormalCosine) {
        patch.fits = true;
      } else if (known.distance_m > 0.0) {
        patch.is_in_front = true;
      }
    }
  }

  void CompareObject(const TrackedObject& object, const VoxelScale& scale) {
    Box bounds = object.bounds_object();
    if (object.is_archived() || bounds.isEmpty()) return;
    bounds.min().array() -= scale.truncation_m;
    bounds.max().array() += scale.truncation_m;
    const Eigen::Isometry3d T_world_object = object.state().T_world_object.ToIsometry();
    CompareVolume(object.volume(), scale, T_world_object.inverse(), &bounds);
    LookThrough(object, T_world_object.cast<float>());
  }

 private:
  Patch& At(int column, int row) {
    return patches_[static_cast<std::size_t>(row * wide_ + column)];
  }

  void LookThrough(const TrackedObject& object, const Eigen::Isometry3f& T_world_object) {
    const Eigen::Isometry3f T_camera_object = T_camera_world_ * T_world_object;
    const PinholeCamera& camera = frame_.cloud.camera();
    const auto fx = static_cast<float>(camera.fx) / SampleGrid::kStrideCells;
    const auto fy = static_cast<float>(camera.fy) / SampleGrid::kStrideCells;
    const auto cx = static_cast<float>(camera.cx) / SampleGrid::kStrideCells;
    const auto cy = static_cast<float>(camera.cy) / SampleGrid::kStrideCells;
    std::size_t count = 0;
    for (const SurfaceLeaf& leaf : object.surface().leaves()) {
      for (const SurfaceVoxel& point : leaf.points) {
        if (count++ % kPointStride != 0) continue;
        const Eigen::Vector3f p = T_camera_object * point.position_object;
        if (p.z() < 0.3F || p.z() > 5.0F) continue;
        const Eigen::Vector3f normal = T_camera_object.linear() * point.normal_object;
        if (-normal.dot(p) < kMinFacing * p.norm()) continue;
        const int column = static_cast<int>(std::floor(fx * p.x() / p.z() + cx + 0.5F));
        const int row = static_cast<int>(std::floor(fy * p.y() / p.z() + cy + 0.5F));
        if (column < 0 || row < 0 || column / kPatchSamples >= wide_ ||
            row / kPatchSamples >= high_)
          continue;
        if (frame_.tiles.NearestAround(column, row) > p.z() + kThroughM) {
          At(column / kPatchSamples, row / kPatchSamples).is_through = true;
        }
      }
    }
  }

  const FrameSurface& frame_;
  Eigen::Isometry3f T_camera_world_;
  int wide_;
  int high_;
  std::vector<Patch> patches_;
  Box bounds_world_;
};

}  // namespace

FrameAgreement CompareFrame(const FrameSurface& frame,
                            const Eigen::Isometry3d& T_world_camera,
                            const WorkingMap& map) {
  PatchGrid grid(frame, T_world_camera);
  for (const auto& [id, object] : map.objects()) grid.CompareObject(object, map.scale());
  grid.CompareVolume(map.background(), map.scale(), Eigen::Isometry3d::Identity(), nullptr);
  FrameAgreement agreement;
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
