#include "core/association/association.h"

#include <algorithm>
#include <cmath>

#include "core/association/frame_clusters.h"
#include "core/volume/tsdf_sample.h"

namespace steadymap {
namespace {

constexpr double kFitBaseM = 0.045;
constexpr double kFitPerSquareMetre = 0.004;

// The base is at most so many truncation distances: finer maps tell smaller things apart.
constexpr double kFitTruncations = 0.3;

// A surface seen from behind is another one: the far side of a fence.
constexpr double kMinSameSideCosine = 0.3;

/// Samples that a box covers in the picture; everything if it reaches behind the camera.
ObjectInView CoverOf(TrackedObject* object,
                     const Box& box,
                     const SemanticCloud& cloud,
                     const SampleGrid& samples) {
  ObjectInView cover{object, 0, samples.width(), 0, samples.height()};
  const Eigen::Isometry3d T_camera_object =
      cloud.T_world_camera().inverse() * object->state().T_world_object.ToIsometry();
  Eigen::Vector2d low(1e9, 1e9);
  Eigen::Vector2d high(-1e9, -1e9);
  bool is_ahead = false;
  bool is_whole = true;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d point_camera =
        T_camera_object * box.corner(static_cast<Box::CornerType>(corner));
    if (point_camera.z() < 0.05) {
      is_whole = false;
      continue;
    }
    is_ahead = true;
    const Eigen::Vector2d cell = cloud.camera().Project(point_camera);
    low = low.cwiseMin(cell);
    high = high.cwiseMax(cell);
  }
  if (!is_ahead) {
    cover.end_column = 0;
  } else if (is_whole) {
    const auto clamp = [](double cell, int end) {
      return static_cast<int>(std::clamp(cell / SampleGrid::kStrideCells, -1.0, end + 1.0));
    };
    cover.first_column = std::max(clamp(std::floor(low.x()), samples.width()), 0);
    cover.end_column = std::min(clamp(std::ceil(high.x()), samples.width()) + 1, samples.width());
    cover.first_row = std::max(clamp(std::floor(low.y()), samples.height()), 0);
    cover.end_row = std::min(clamp(std::ceil(high.y()), samples.height()) + 1, samples.height());
  }
  return cover;
}

/// Offers one volume to the samples of a rectangle.
class Claimant {
 public:
  Claimant(const VoxelReader& volume,
           const VoxelScale& scale,
           const Eigen::Isometry3d& T_volume_world,
           std::uint32_t owner)
      : sampler_(volume, scale),
        truncation_m_(scale.truncation_m),
        T_volume_world_(T_volume_world),
        owner_(owner) {}

  void Claim(const SurfaceSample& sample, std::size_t index, Association* association) {
    const Eigen::Vector3d position = T_volume_world_ * sample.position_world.cast<double>();
    double distance_m = 0.0;
    const bool is_inner = sampler_.SampleDistance(position, &distance_m);
    if (!is_inner && !sampler_.SampleNearest(position, &distance_m)) return;
    const double magnitude_m = std::abs(distance_m);
    const double tolerance_m = FitTolerance(sample.depth_m, truncation_m_);
    if (is_inner && distance_m > tolerance_m) association->is_in_front[index] = 1;
    if (magnitude_m > tolerance_m ||
        (association->owner[index] != Association::kNone &&
         magnitude_m >= static_cast<double>(std::abs(association->distance_m[index])))) {
      return;
    }
    const Eigen::Vector3d normal = T_volume_world_.linear() * sample.normal_world.cast<double>();
    if (is_inner && sampler_.Sample(position).gradient.dot(normal) < kMinSameSideCosine) return;
    association->owner[index] = owner_;
    association->distance_m[index] = static_cast<float>(distance_m);
  }

 private:
  TsdfSampler sampler_;
  double truncation_m_;
  Eigen::Isometry3d T_volume_world_;
  std::uint32_t owner_;
};

/// Offers an object to the samples that its bounds hold.
void OfferObject(const SampleGrid& samples,
                 const ObjectInView& view,
                 std::uint32_t owner,
                 const VoxelScale& scale,
                 const FrameClusters& clusters,
                 Association* association) {
  const Eigen::Isometry3d T_object_world =
      view.object->state().T_world_object.ToIsometry().inverse();
  Claimant claimant(view.object->volume(), scale, T_object_world, owner);
  const auto margin_m = static_cast<float>(scale.truncation_m);
  Eigen::AlignedBox3f bounds = view.object->bounds_object().cast<float>();
  bounds.min().array() -= margin_m;
  bounds.max().array() += margin_m;
  const Eigen::Isometry3f T_bounds_world = T_object_world.cast<float>();
  for (int row = view.first_row; row < view.end_row; ++row) {
    for (int column = view.first_column; column < view.end_column; ++column) {
      const std::size_t index = samples.Index(column, row);
      const SurfaceSample& sample = samples[index];
      if (sample.is_valid() && bounds.contains(T_bounds_world * sample.position_world) &&
          clusters.MayClaim(*view.object, index)) {
        claimant.Claim(sample, index, association);
      }
    }
  }
}

}  // namespace

double FitTolerance(float depth_m, double truncation_m) {
  const auto depth = static_cast<double>(depth_m);
  return std::min(kFitBaseM, kFitTruncations * truncation_m) + kFitPerSquareMetre * depth * depth;
}

Box ReachOfView(const SemanticCloud& cloud, double max_range_m) {
  const Eigen::Vector3d camera_world = cloud.T_world_camera().translation();
  const Eigen::Vector3d reach = Eigen::Vector3d::Constant(max_range_m);
  return {camera_world - reach, camera_world + reach};
}

std::vector<ObjectInView> FindObjectsInView(const std::vector<TrackedObject*>& objects,
                                            const SemanticCloud& cloud,
                                            const SampleGrid& samples,
                                            double max_range_m) {
  std::vector<ObjectInView> in_view;
  const Eigen::Vector3d camera_world = cloud.T_world_camera().translation();
  for (TrackedObject* object : objects) {
    if (object->is_archived() || object->bounds_object().isEmpty()) continue;
    const Eigen::Vector3d camera_object =
        object->state().T_world_object.ToIsometry().inverse() * camera_world;
    if (object->bounds_object().exteriorDistance(camera_object) > max_range_m) continue;
    const ObjectInView cover = CoverOf(object, object->bounds_object(), cloud, samples);
    if (cover.first_column < cover.end_column && cover.first_row < cover.end_row) {
      in_view.push_back(cover);
    }
  }
  return in_view;
}

void AssociateSamples(const SampleGrid& samples,
                      const std::vector<ObjectInView>& objects,
                      const Background& background,
                      const VoxelScale& scale,
                      const FrameClusters& clusters,
                      Association* association) {
  association->owner.assign(samples.size(), Association::kNone);
  association->distance_m.assign(samples.size(), 0.0F);
  association->is_in_front.assign(samples.size(), 0);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const auto owner = static_cast<std::uint32_t>(i + 1);
    OfferObject(samples, objects[i], owner, scale, clusters, association);
  }
  // What once went into the background stays there: of things it gets what no object explains, lest
  // it take them over bit by bit.
  Claimant claimant(background, scale, Eigen::Isometry3d::Identity(), kBackgroundOwner);
  for (std::size_t index = 0; index < samples.size(); ++index) {
    const SurfaceSample& sample = samples[index];
    if (sample.is_valid() &&
        (association->owner[index] == Association::kNone || !clusters.FormsObjects(sample))) {
      claimant.Claim(sample, index, association);
    }
  }
}

void ReleaseSamples(std::uint32_t owner, Association* association) {
  for (std::size_t index = 0; index < association->owner.size(); ++index) {
    if (association->owner[index] != owner) continue;
    association->owner[index] = Association::kNone;
    association->is_in_front[index] = 1;
  }
}

}  // namespace steadymap
