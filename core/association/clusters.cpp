#include "core/association/clusters.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>

#include <pcl/ModelCoefficients.h>
#include <pcl/PointIndices.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/extract_clusters.h>
#include <pcl/segmentation/sac_segmentation.h>

#include "core/association/ground.h"
#include "core/geometry/cuboid.h"

namespace steadymap {
namespace {

using ClusterPoints = pcl::PointCloud<pcl::PointXYZ>;

// Bounds the time of a frame.
constexpr int kMaxPlanes = 8;

// Finds a plane of a fifth of all points with a probability of 98 %.
constexpr int kMaxPlaneTrials = 500;

// A sample on a plane has a normal within 30 degrees of the plane's; other surface only crosses it.
constexpr float kMinPlaneCosine = 0.866F;

// A plane that faces down within 10 degrees, above the camera, is a ceiling.
constexpr float kLevelCosine = 0.985F;

// Points of one class closer than this share of the cluster distance count as one, which bounds the
// number of neighbours of a point.
constexpr double kClusterCells = 4.0;

/// The samples of a frame, their classes by plane, and their clusters.
class FrameClustering {
 public:
  FrameClustering(const SampleGrid& samples,
                  const MapConfig& config,
                  const Eigen::Vector3d& camera_world,
                  const ClusterParameters& parameters,
                  Association* association)
      : samples_(samples),
        config_(config),
        camera_world_(camera_world.cast<float>()),
        parameters_(parameters),
        association_(*association),
        label_of_(samples.size()) {
    for (std::size_t i = 0; i < samples.size(); ++i) label_of_[i] = samples[i].label;
    association_.owner.assign(samples.size(), Association::kNone);
    if (const auto ground = FindGroundHeight(samples, camera_world.z())) {
      AssignGround(samples, *ground, association);
    }
  }

  std::vector<Observation> Run() {
    VoteOnPlanes();
    std::vector<Observation> clusters = FindAll();
    KeepLargest(&clusters);  // Before pairs of them are compared.
    return Merge(clusters);
  }

 private:
  bool IsOpen(std::size_t index) const {
    return samples_[index].is_valid() && association_.owner[index] == Association::kNone;
  }

  /// PCL uses single precision, which is sufficient near the camera.
  pcl::PointXYZ PointOf(std::size_t index) const {
    const Eigen::Vector3f point = samples_[index].position_world - camera_world_;
    return {point.x(), point.y(), point.z()};
  }

  std::vector<Eigen::Vector3d> PointsOf(const Observation& cluster) const {
    std::vector<Eigen::Vector3d> points_world;
    points_world.reserve(cluster.samples.size());
    for (const std::size_t index : cluster.samples) {
      points_world.emplace_back(samples_[index].position_world.cast<double>());
    }
    return points_world;
  }

  /// Finds planes, the largest one first, and votes on the class of each connected part of them.
  void VoteOnPlanes() {
    std::vector<std::size_t> rest;
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      if (IsOpen(i)) rest.push_back(i);
    }
    for (int plane = 0; plane < kMaxPlanes; ++plane) {
      if (rest.size() < parameters_.min_plane_samples) return;
      Eigen::Vector3f normal = Eigen::Vector3f::Zero();
      const std::vector<std::size_t> found = TakePlane(&rest, &normal);
      if (found.size() < parameters_.min_plane_samples) return;
      if (IsCeiling(found.front(), normal)) {
        for (const std::size_t index : found) association_.owner[index] = kBackgroundOwner;
        continue;
      }
      for (const std::vector<std::size_t>& part : EuclideanClusters(found)) {
        if (part.size() >= parameters_.min_plane_samples) VoteOn(part);
      }
    }
  }

  void VoteOn(const std::vector<std::size_t>& part) {
    const std::uint16_t label = MajorityLabel(part);
    for (const std::size_t index : part) {
      if (samples_[index].instance == 0) label_of_[index] = label;
    }
  }

  /// Removes the samples of the largest plane from `rest` and returns them.
  std::vector<std::size_t> TakePlane(std::vector<std::size_t>* rest, Eigen::Vector3f* normal) {
    ClusterPoints::Ptr points(new ClusterPoints);
    for (const std::size_t index : *rest) points->push_back(PointOf(index));
    pcl::SACSegmentation<pcl::PointXYZ> ransac;
    ransac.setModelType(pcl::SACMODEL_PLANE);
    ransac.setMethodType(pcl::SAC_RANSAC);
    ransac.setOptimizeCoefficients(true);
    ransac.setDistanceThreshold(parameters_.plane_distance_m);
    ransac.setMaxIterations(kMaxPlaneTrials);
    ransac.setInputCloud(points);
    pcl::PointIndices inliers;
    pcl::ModelCoefficients plane;
    ransac.segment(inliers, plane);
    if (plane.values.size() < 3) return {};
    *normal = Eigen::Vector3f(plane.values[0], plane.values[1], plane.values[2]);
    std::vector<std::uint8_t> is_taken(rest->size(), 0);
    std::vector<std::size_t> found;
    for (const pcl::index_t inlier : inliers.indices) {
      const auto place = static_cast<std::size_t>(inlier);
      const std::size_t index = (*rest)[place];
      if (std::abs(samples_[index].normal_world.dot(*normal)) < kMinPlaneCosine) continue;
      is_taken[place] = 1;
      found.push_back(index);
    }
    std::size_t kept = 0;
    for (std::size_t place = 0; place < rest->size(); ++place) {
      if (is_taken[place] == 0) (*rest)[kept++] = (*rest)[place];
    }
    rest->resize(kept);
    return found;
  }

  /// Whether a plane is level, above the camera, and faces down. `index`: one of its samples.
  bool IsCeiling(std::size_t index, const Eigen::Vector3f& normal) const {
    return std::abs(normal.z()) > kLevelCosine &&
           samples_[index].position_world.z() > camera_world_.z() &&
           samples_[index].normal_world.z() < 0.0F;
  }

  /// The smallest of the most frequent labels of samples, zero if there are none.
  std::uint16_t MajorityLabel(const std::vector<std::size_t>& indices) const {
    std::map<std::uint16_t, std::size_t> votes;
    for (const std::size_t index : indices) ++votes[label_of_[index]];
    std::pair<std::uint16_t, std::size_t> best{0, 0};
    for (const auto& [label, count] : votes) {
      if (count > best.second) best = {label, count};
    }
    return best.first;
  }

  /// Clusters the samples of each instance and of each class that forms objects; the rest is of the
  /// background.
  std::vector<Observation> FindAll() {
    std::map<std::pair<std::uint16_t, std::uint16_t>, std::vector<std::size_t>> groups;
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      if (!IsOpen(i)) continue;
      const std::uint16_t instance = samples_[i].instance;
      if (instance == 0 && config_.IsInBackground(ClassId(label_of_[i]))) {
        association_.owner[i] = kBackgroundOwner;
        continue;
      }
      const std::uint16_t label = instance == 0 ? label_of_[i] : std::uint16_t{0};
      groups[{instance, label}].push_back(i);
    }
    std::vector<Observation> clusters;
    for (const auto& [key, indices] : groups) AddClusters(key.first, indices, &clusters);
    return clusters;
  }

  void AddClusters(std::uint16_t instance,
                   const std::vector<std::size_t>& indices,
                   std::vector<Observation>* clusters) {
    for (std::vector<std::size_t>& cluster : EuclideanClusters(indices)) {
      if (cluster.size() < parameters_.min_cluster_samples) continue;
      Observation observation;
      observation.instance = instance;
      observation.samples = std::move(cluster);
      Complete(&observation);
      clusters->push_back(std::move(observation));
    }
  }

  /// Divides samples into groups that are farther apart than the cluster distance.
  std::vector<std::vector<std::size_t>> EuclideanClusters(
      const std::vector<std::size_t>& indices) const {
    // The samples of a cell, whose first one stands for it.
    std::vector<std::vector<std::size_t>> cells;
    ClusterPoints::Ptr points(new ClusterPoints);
    std::map<std::tuple<int, int, int>, std::size_t> place_of;
    const auto per_metre = static_cast<float>(kClusterCells / parameters_.cluster_distance_m);
    for (const std::size_t index : indices) {
      const pcl::PointXYZ point = PointOf(index);
      const std::tuple<int, int, int> cell(static_cast<int>(std::floor(point.x * per_metre)),
                                           static_cast<int>(std::floor(point.y * per_metre)),
                                           static_cast<int>(std::floor(point.z * per_metre)));
      const auto [place, is_new] = place_of.try_emplace(cell, cells.size());
      if (is_new) {
        points->push_back(point);
        cells.emplace_back();
      }
      cells[place->second].push_back(index);
    }
    pcl::EuclideanClusterExtraction<pcl::PointXYZ> search;
    search.setClusterTolerance(parameters_.cluster_distance_m);
    search.setMinClusterSize(1);
    search.setSearchMethod(std::make_shared<pcl::search::KdTree<pcl::PointXYZ>>());
    search.setInputCloud(points);
    std::vector<pcl::PointIndices> found;
    search.extract(found);
    std::vector<std::vector<std::size_t>> clusters(found.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
      for (const pcl::index_t place : found[i].indices) {
        const std::vector<std::size_t>& cell = cells[static_cast<std::size_t>(place)];
        clusters[i].insert(clusters[i].end(), cell.begin(), cell.end());
      }
    }
    return clusters;
  }

  /// Sets what follows from the samples, and their order.
  void Complete(Observation* observation) const {
    std::sort(observation->samples.begin(), observation->samples.end());
    observation->label = MajorityLabel(observation->samples);
    observation->area_m2 = 0.0;
    for (const std::size_t index : observation->samples) {
      observation->area_m2 += static_cast<double>(samples_[index].area_m2);
    }
  }

  /// Merges clusters with overlapping cuboids, and those that overlap with one of them.
  std::vector<Observation> Merge(const std::vector<Observation>& clusters) const {
    std::vector<Cuboid> cuboids;
    cuboids.reserve(clusters.size());
    for (const Observation& cluster : clusters)
      cuboids.push_back(MajorAxisCuboid(PointsOf(cluster)));
    std::vector<std::size_t> root_of(clusters.size());
    std::iota(root_of.begin(), root_of.end(), std::size_t{0});
    const auto root = [&root_of](std::size_t i) {
      while (root_of[i] != i) i = root_of[i];
      return i;
    };
    for (std::size_t i = 0; i < clusters.size(); ++i) {
      for (std::size_t k = 0; k < i; ++k) {
        if (clusters[i].instance != 0 || clusters[k].instance != 0) continue;
        const double smaller_m3 = std::min(cuboids[i].volume_m3(), cuboids[k].volume_m3());
        if (!(smaller_m3 > 0.0) ||
            OverlapM3(cuboids[i], cuboids[k]) < parameters_.min_merged_overlap * smaller_m3) {
          continue;
        }
        const std::size_t first = root(i);
        const std::size_t second = root(k);
        root_of[std::max(first, second)] = std::min(first, second);
      }
    }
    std::map<std::size_t, Observation> merged;
    for (std::size_t i = 0; i < clusters.size(); ++i) {
      Observation& into = merged[root(i)];
      into.instance = clusters[i].instance;
      into.samples.insert(
          into.samples.end(), clusters[i].samples.begin(), clusters[i].samples.end());
    }
    std::vector<Observation> observations;
    observations.reserve(merged.size());
    for (auto& [first, observation] : merged) {
      Complete(&observation);
      observations.push_back(std::move(observation));
    }
    std::sort(
        observations.begin(), observations.end(), [](const Observation& a, const Observation& b) {
          return a.samples.front() < b.samples.front();
        });
    return observations;
  }

  const SampleGrid& samples_;
  const MapConfig& config_;
  Eigen::Vector3f camera_world_;
  const ClusterParameters& parameters_;
  Association& association_;
  std::vector<std::uint16_t> label_of_;  ///< By sample; after the vote, that of its plane.
};

}  // namespace

std::vector<Observation> FindClusters(const SampleGrid& samples,
                                      const MapConfig& config,
                                      const Eigen::Vector3d& camera_world,
                                      const ClusterParameters& parameters,
                                      Association* association) {
  return FrameClustering(samples, config, camera_world, parameters, association).Run();
}

}  // namespace steadymap
