#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "core/association/association.h"
#include "core/association/observation.h"
#include "core/association/sample_grid.h"
#include "core/types/map_config.h"
#include "core/working/tracked_object.h"

namespace steadymap {

/// How clusters bound what objects may claim: as the paper has it, or (the defaults) not at all.
struct ClusterParameters {
  /// Centres of an object and of a cluster lie no further apart, metres (theta_dist).
  double center_distance_m = std::numeric_limits<double>::infinity();
  /// Whether a cluster is matched whole, with one object at most, and an object with one cluster.
  bool is_one_to_one = false;
  /// Then, the largest share of a cluster that does not lie on its object (theta_sim); what is not
  /// mapped yet does not.
  double max_dissimilarity = 0.10;

  /// Whether they bound anything.
  bool is_on() const {
    return is_one_to_one || center_distance_m < std::numeric_limits<double>::infinity();
  }
};

/// The connected surfaces of one label that a frame falls into by itself, whatever the map knows
/// (the observations of Qian et al., RSS 2022). Ground and background belong to none. There are
/// none, and nothing is bounded, unless the parameters ask for it. One frame at a time, one thread.
class FrameClusters {
 public:
  FrameClusters(const MapConfig& config, const ClusterParameters& parameters)
      : config_(config), parameters_(parameters) {}

  /// Parts a frame, taken `camera_height_m` above the world's origin.
  void Compute(const SampleGrid& samples, double camera_height_m);

  /// Whether an object may claim a sample: the sample's cluster has its centre near that of the
  /// object, or the sample is of no cluster.
  bool MayClaim(const TrackedObject& object, std::size_t sample) const {
    return cluster_of_.empty() || IsCenteredNear(object, sample);
  }

  /// Whether a sample's class forms objects, not background.
  bool FormsObjects(const SurfaceSample& sample) const {
    return !config_.IsInBackground(ClassId(sample.label));
  }

  /// Goes from samples that found objects to clusters that did: of every cluster with an object of
  /// its class on which nearly all of it lies, all samples are that object's; one cluster an
  /// object, those that lie on theirs best. Of all others, no sample is any object's.
  /// Nothing happens where clusters need not be matched so.
  void MatchOneToOne(const std::vector<ObjectInView>& objects, Association* association) const;

 private:
  bool IsCenteredNear(const TrackedObject& object, std::size_t sample) const;

  MapConfig config_;
  ClusterParameters parameters_;
  std::vector<Observation> clusters_;
  std::vector<Eigen::Vector3d> centers_world_;  ///< By cluster.
  std::vector<std::uint32_t> cluster_of_;       ///< By sample; `Association::kNone`: none.
};

}  // namespace steadymap
