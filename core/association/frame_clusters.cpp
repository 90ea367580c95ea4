#include "core/association/frame_clusters.h"

#include <optional>

#include "core/association/segmentation.h"
#include "core/geometry/assignment.h"

namespace steadymap {
namespace {

// Above the cost of any pair, which is a share of outliers.
constexpr double kUnmatchedClusterCost = 2.0;

}  // namespace

void FrameClusters::Compute(const SampleGrid& samples, double camera_height_m) {
  if (!parameters_.is_on()) return;
  Association unowned;
  clusters_ = FindSegments(samples, config_, camera_height_m, &unowned);
  cluster_of_.assign(samples.size(), Association::kNone);
  centers_world_.clear();
  centers_world_.reserve(clusters_.size());
  for (std::size_t cluster = 0; cluster < clusters_.size(); ++cluster) {
    Eigen::AlignedBox3d bounds_world;
    for (const std::size_t sample : clusters_[cluster].samples) {
      cluster_of_[sample] = static_cast<std::uint32_t>(cluster);
      bounds_world.extend(samples[sample].position_world.cast<double>());
    }
    centers_world_.emplace_back(bounds_world.center());
  }
}

bool FrameClusters::IsCenteredNear(const TrackedObject& object, std::size_t sample) const {
  const std::uint32_t cluster = cluster_of_[sample];
  if (cluster == Association::kNone) return true;
  const Eigen::Vector3d apart_m = centers_world_[cluster] - object.cuboid().center_world;
  return apart_m.norm() <= parameters_.center_distance_m;
}

void FrameClusters::MatchOneToOne(const std::vector<ObjectInView>& objects,
                                  Association* association) const {
  if (!parameters_.is_one_to_one) return;
  std::vector<AssignmentPair> pairs;
  for (std::size_t cluster = 0; cluster < clusters_.size(); ++cluster) {
    std::vector<std::size_t> fitting(objects.size(), 0);
    for (const std::size_t sample : clusters_[cluster].samples) {
      const std::uint32_t owner = association->owner[sample];
      if (Association::IsObject(owner)) ++fitting[owner - 1];
    }
    const auto size = static_cast<double>(clusters_[cluster].samples.size());
    for (std::size_t object = 0; object < objects.size(); ++object) {
      const double dissimilarity = 1.0 - static_cast<double>(fitting[object]) / size;
      if (dissimilarity <= parameters_.max_dissimilarity &&
          objects[object].object->state().class_id.value() == clusters_[cluster].label) {
        pairs.push_back({cluster, object, dissimilarity});
      }
    }
  }
  const std::vector<std::optional<std::size_t>> matches =
      AssignColumns(clusters_.size(), objects.size(), pairs, kUnmatchedClusterCost);
  for (std::size_t sample = 0; sample < cluster_of_.size(); ++sample) {
    if (association->owner[sample] == kBackgroundOwner) continue;
    const std::uint32_t cluster = cluster_of_[sample];
    const bool is_matched = cluster != Association::kNone && matches[cluster].has_value();
    association->owner[sample] =
        is_matched ? static_cast<std::uint32_t>(*matches[cluster] + 1) : Association::kNone;
  }
}

}  // namespace steadymap
