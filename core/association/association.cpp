#include "core/association/association.h"

#include <algorithm>
#include <cmath>

namespace steadymap {
namespace {

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

}  // namespace

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

}  // namespace steadymap
