#include "core/policy/segment_fusion.h"

#include <algorithm>
#include <utility>

#include "core/association/cell_ownership.h"
#include "core/association/new_object.h"
#include "core/association/segmentation.h"

namespace steadymap {

SegmentFusion::SegmentFusion(const MapConfig& config, const SegmentFusionParameters& parameters)
    : SegmentFusion(config,
                    parameters,
                    [config](const SampleGrid& samples,
                             const Eigen::Vector3d& camera_world,
                             Association* association) {
                      return FindSegments(samples, config, camera_world, association);
                    }) {}

SegmentFusion::SegmentFusion(const MapConfig& config,
                             const SegmentFusionParameters& parameters,
                             FrameDivision division)
    : parameters_(parameters), division_(std::move(division)), integrator_(config) {}

std::vector<TrackedObject*> SegmentFusion::Candidates(const SemanticCloud& cloud,
                                                      WorkingMap* map) const {
  return map->ObjectsNear(ReachOfView(cloud, parameters_.max_depth_m));
}

void SegmentFusion::Part(const std::vector<TrackedObject*>& candidates,
                         SemanticCloud* cloud,
                         WorkingMap* map) {
  map_ = map;
  cloud_ = cloud;
  samples_.Compute(*cloud);
  segments_ = division_(samples_, cloud->T_world_camera().translation(), &association_);
  is_discarded_.assign(segments_.size(), 0);
  in_view_ = FindObjectsInView(candidates, *cloud, samples_, parameters_.max_depth_m);
  SetMatches(std::vector<std::optional<std::size_t>>(segments_.size()));
}

void SegmentFusion::SetMatches(std::vector<std::optional<std::size_t>> matches) {
  matches_ = std::move(matches);
  segments_of_.assign(in_view_.size(), {});
  for (std::size_t i = 0; i < matches_.size(); ++i) {
    if (matches_[i]) segments_of_[*matches_[i]].push_back(i);
  }
}

void SegmentFusion::Match(const std::vector<TrackedObject*>& candidates,
                          SemanticCloud* cloud,
                          WorkingMap* map) {
  Part(candidates, cloud, map);
  SetMatches(
      MatchByOverlap(segments_, in_view_, *cloud, samples_, map->scale(), parameters_.overlap));
}

std::vector<Eigen::Vector3d> SegmentFusion::PointsOf(const Observation& segment) const {
  std::vector<Eigen::Vector3d> points_world;
  points_world.reserve(segment.samples.size());
  for (const std::size_t index : segment.samples) {
    points_world.emplace_back(samples_[index].position_world.cast<double>());
  }
  return points_world;
}

std::size_t SegmentFusion::CountSamples(std::size_t place) const {
  std::size_t count = 0;
  for (const std::size_t i : segments_of_[place]) count += segments_[i].samples.size();
  return count;
}

std::vector<Eigen::Vector3d> SegmentFusion::PointsOf(std::size_t place) const {
  std::vector<std::size_t> indices;
  for (const std::size_t i : segments_of_[place]) {
    indices.insert(indices.end(), segments_[i].samples.begin(), segments_[i].samples.end());
  }
  std::sort(indices.begin(), indices.end());
  std::vector<Eigen::Vector3d> points_world;
  points_world.reserve(indices.size());
  for (const std::size_t index : indices) {
    points_world.emplace_back(samples_[index].position_world.cast<double>());
  }
  return points_world;
}

void SegmentFusion::Release(std::size_t place) {
  for (const std::size_t i : segments_of_[place]) matches_[i].reset();
  segments_of_[place].clear();
}

void SegmentFusion::Discard(std::size_t place) {
  for (const std::size_t i : segments_of_[place]) is_discarded_[i] = 1;
  Release(place);
}

void SegmentFusion::AddObjects() {
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    if (matches_[i] || is_discarded_[i] != 0) continue;
    if (segments_[i].area_m2 < parameters_.min_new_area_m2) continue;
    matches_[i] = in_view_.size();
    segments_of_.push_back({i});
    TrackedObject& object = AddObjectOf(segments_[i], samples_, map_);
    in_view_.push_back({&object, 0, samples_.width(), 0, samples_.height()});
  }
}

void SegmentFusion::Fuse() {
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    if (!matches_[i]) continue;
    for (const std::size_t index : segments_[i].samples) {
      association_.owner[index] = static_cast<std::uint32_t>(*matches_[i] + 1);
    }
  }
  GiveCellsToOwners(samples_, association_, cloud_);
  integrator_.SetFrame(*cloud_);
  map_->FuseBackground(&integrator_);
  for (std::size_t place = 0; place < in_view_.size(); ++place) {
    if (CountSamples(place) == 0) continue;
    map_->FuseObject(static_cast<std::uint32_t>(place + 1), in_view_[place].object, &integrator_);
  }
}

}  // namespace steadymap
