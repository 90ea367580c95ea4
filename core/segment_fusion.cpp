#include "core/segment_fusion.h"

#include "core/cell_ownership.h"
#include "core/new_object.h"
#include "core/segmentation.h"

namespace steadymap {

SegmentFusion::SegmentFusion(const MapConfig& config, const SegmentFusionParameters& parameters)
    : config_(config), parameters_(parameters), integrator_(config) {}

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
  const double camera_height_m = cloud->T_world_camera().translation().z();
  segments_ = FindSegments(samples_, config_, camera_height_m, &association_);
  in_view_ = FindObjectsInView(candidates, *cloud, samples_, parameters_.max_depth_m);
  matches_.assign(segments_.size(), std::nullopt);
}

void SegmentFusion::Match(const std::vector<TrackedObject*>& candidates,
                          SemanticCloud* cloud,
                          WorkingMap* map) {
  Part(candidates, cloud, map);
  matches_ =
      MatchByOverlap(segments_, in_view_, *cloud, samples_, map->scale(), parameters_.overlap);
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
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    if (matches_[i] == place) count += segments_[i].samples.size();
  }
  return count;
}

std::vector<Eigen::Vector3d> SegmentFusion::PointsOf(std::size_t place) const {
  std::vector<std::uint8_t> is_part(samples_.size(), 0);
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    if (matches_[i] != place) continue;
    for (const std::size_t index : segments_[i].samples) is_part[index] = 1;
  }
  std::vector<Eigen::Vector3d> points_world;
  for (std::size_t index = 0; index < samples_.size(); ++index) {
    if (is_part[index] != 0)
      points_world.emplace_back(samples_[index].position_world.cast<double>());
  }
  return points_world;
}

void SegmentFusion::Release(std::size_t place) {
  for (std::optional<std::size_t>& match : matches_) {
    if (match == place) match.reset();
  }
}

void SegmentFusion::AddObjects() {
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    if (matches_[i] || segments_[i].area_m2 < parameters_.min_new_area_m2) continue;
    matches_[i] = in_view_.size();
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
  map_->FuseBackground(*cloud_, &integrator_);
  const CellRange everywhere{0, cloud_->cells_wide(), 0, cloud_->cells_high()};
  for (std::size_t place = 0; place < in_view_.size(); ++place) {
    if (CountSamples(place) == 0) continue;
    map_->FuseObject(*cloud_,
                     {static_cast<std::uint32_t>(place + 1), everywhere},
                     in_view_[place].object,
                     &integrator_);
  }
}

}  // namespace steadymap
