#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "core/association/association.h"
#include "core/association/observation.h"
#include "core/association/sample_grid.h"
#include "core/types/map_config.h"

namespace steadymap {

/// The constants of `FindClusters`. Qian et al., RSS 2022, state the steps, but no values.
struct ClusterParameters {
  /// A sample within this distance of a plane belongs to the plane, metres, > 0.
  double plane_distance_m = 0.05;
  /// The least number of samples of a plane. A larger value leaves more noise in the labels, a
  /// smaller value gives small objects the label of what they stand beside.
  std::size_t min_plane_samples = 500;
  /// Samples of one class within this distance belong to one cluster, metres, > 0.
  double cluster_distance_m = 0.1;
  /// Smaller clusters are outliers, >= 1.
  std::size_t min_cluster_samples = 20;
  /// Clusters whose cuboids share at least this part of the volume of the smaller one are merged,
  /// in (0, 1].
  double min_merged_overlap = 0.5;

  friend bool operator==(const ClusterParameters&, const ClusterParameters&) = default;
};

/// Divides a frame into observations in the way of Qian et al., RSS 2022, whatever the map knows:
///
/// 1. The ground and ceilings belong to the background.
/// 2. All samples of a connected part of a plane get the class of most of them, since walls and
///    racks are planar and labels are noisy. RANSAC finds the planes, the largest one first.
/// 3. Euclidean clusters of one class are observations, if the class forms objects; small ones are
///    outliers. Samples with an instance id are clustered by instance, and keep their class.
/// 4. Clusters with overlapping cuboids merge. The class is that of most samples. Cuboids have the
///    heading of the major axis of their points. Instances do not merge.
///
/// Sets the owner of each sample: the background or, for outliers and samples of observations,
/// none. Observations are in the order of their first samples, which rise; at most
/// `kMaxObservations`. Equal input gives an equal result. Planes and clusters are found by PCL.
std::vector<Observation> FindClusters(const SampleGrid& samples,
                                      const MapConfig& config,
                                      const Eigen::Vector3d& camera_world,
                                      const ClusterParameters& parameters,
                                      Association* association);

}  // namespace steadymap
