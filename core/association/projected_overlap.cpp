#include "core/association/projected_overlap.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace steadymap {
namespace {

// Nearer than this a point would cover the picture.
constexpr float kMinDrawnDepthM = 0.05F;
constexpr std::uint32_t kNoSegment = 0xFFFFFFFFU;

// Surface points stand a voxel apart, so each is drawn as a square of a voxel's size and a little.
constexpr float kHalfPointVoxels = 0.6F;

/// Draws the surface of one object at a time into a grid of depths.
class SurfaceDrawing {
 public:
  SurfaceDrawing(const SemanticCloud& cloud, const SampleGrid& samples, const VoxelScale& scale)
      : camera_(cloud.camera()),
        width_(samples.width()),
        height_(samples.height()),
        focal_x_(static_cast<float>(cloud.camera().fx / SampleGrid::kStrideCells)),
        focal_y_(static_cast<float>(cloud.camera().fy / SampleGrid::kStrideCells)),
        half_point_m_(kHalfPointVoxels * static_cast<float>(scale.voxel_size_m)),
        T_camera_world_(cloud.T_world_camera().inverse()),
        depth_m_(samples.size(), kNothing) {}

  /// Nothing was drawn at a sample.
  static constexpr float kNothing = std::numeric_limits<float>::infinity();

  void Draw(const TrackedObject& object) {
    const Eigen::Isometry3f T_camera_object =
        (T_camera_world_ * object.state().T_world_object.ToIsometry()).cast<float>();
    for (const SurfaceLeaf& leaf : object.surface().leaves()) {
      for (const SurfaceVoxel& point : leaf.points) {
        const Eigen::Vector3f point_camera = T_camera_object * point.position_object;
        const Eigen::Vector3f normal_camera = T_camera_object.linear() * point.normal_object;
        if (point_camera.z() > kMinDrawnDepthM && normal_camera.dot(point_camera) < 0.0F) {
          DrawPoint(point_camera);
        }
      }
    }
  }

  /// Depth drawn at a sample.
  float At(std::size_t index) const { return depth_m_[index]; }

  /// The samples drawn at since the last `Clear`, each once.
  const std::vector<std::size_t>& drawn() const { return drawn_; }

  void Clear() {
    for (const std::size_t index : drawn_) depth_m_[index] = kNothing;
    drawn_.clear();
  }

 private:
  void DrawPoint(const Eigen::Vector3f& point_camera) {
    const float inverse_z = 1.0F / point_camera.z();
    // A sample is at the first of its cells.
    const Eigen::Vector2f place = camera_.Project(point_camera) / SampleGrid::kStrideCells;
    const float u = place.x();
    const float v = place.y();
    const float half_u = focal_x_ * half_point_m_ * inverse_z;
    const float half_v = focal_y_ * half_point_m_ * inverse_z;
    const auto width = static_cast<float>(width_);
    const auto height = static_cast<float>(height_);
    if (!(u + half_u > -1.0F && v + half_v > -1.0F && u - half_u < width && v - half_v < height)) {
      return;
    }
    const int first_column = static_cast<int>(std::max(std::ceil(u - half_u), 0.0F));
    const int last_column = static_cast<int>(std::min(std::floor(u + half_u), width - 1.0F));
    const int first_row = static_cast<int>(std::max(std::ceil(v - half_v), 0.0F));
    const int last_row = static_cast<int>(std::min(std::floor(v + half_v), height - 1.0F));
    for (int row = first_row; row <= last_row; ++row) {
      for (int column = first_column; column <= last_column; ++column) {
        const std::size_t index = static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
                                  static_cast<std::size_t>(column);
        if (depth_m_[index] == kNothing) drawn_.push_back(index);
        depth_m_[index] = std::min(depth_m_[index], point_camera.z());
      }
    }
  }

  PinholeCamera camera_;  ///< Of the cells.
  int width_;
  int height_;
  float focal_x_;  ///< Samples at a depth of one metre.
  float focal_y_;
  float half_point_m_;
  Eigen::Isometry3d T_camera_world_;
  std::vector<float> depth_m_;
  std::vector<std::size_t> drawn_;
};

/// Samples that an object covers, and how many of them each segment shares.
struct Coverage {
  std::size_t visible = 0;          ///< Not occluded by what was measured.
  std::vector<std::size_t> shared;  ///< By segment.
};

Coverage CoverageOf(const SurfaceDrawing& drawing,
                    const SampleGrid& samples,
                    const std::vector<std::uint32_t>& segment_of,
                    std::size_t segment_count,
                    double depth_tolerance_m) {
  Coverage coverage{0, std::vector<std::size_t>(segment_count, 0)};
  const auto tolerance_m = static_cast<float>(depth_tolerance_m);
  for (const std::size_t index : drawing.drawn()) {
    if (!samples[index].is_valid()) continue;
    const float behind_m = drawing.At(index) - samples[index].depth_m;
    if (behind_m > tolerance_m) continue;
    ++coverage.visible;
    if (behind_m >= -tolerance_m && segment_of[index] != kNoSegment) {
      ++coverage.shared[segment_of[index]];
    }
  }
  return coverage;
}

}  // namespace

std::vector<std::optional<std::size_t>> MatchByOverlap(const std::vector<Observation>& segments,
                                                       const std::vector<ObjectInView>& objects,
                                                       const SemanticCloud& cloud,
                                                       const SampleGrid& samples,
                                                       const VoxelScale& scale,
                                                       const OverlapParameters& parameters) {
  std::vector<std::uint32_t> segment_of(samples.size(), kNoSegment);
  for (std::size_t i = 0; i < segments.size(); ++i) {
    for (const std::size_t index : segments[i].samples) {
      segment_of[index] = static_cast<std::uint32_t>(i);
    }
  }
  std::vector<std::optional<std::size_t>> matches(segments.size());
  std::vector<double> best(segments.size(), parameters.min_overlap);
  SurfaceDrawing drawing(cloud, samples, scale);
  for (std::size_t place = 0; place < objects.size(); ++place) {
    const TrackedObject& object = *objects[place].object;
    drawing.Draw(object);
    const Coverage coverage =
        CoverageOf(drawing, samples, segment_of, segments.size(), parameters.depth_tolerance_m);
    drawing.Clear();
    for (std::size_t i = 0; i < segments.size(); ++i) {
      if (ClassId(segments[i].label) != object.state().class_id) continue;
      const std::size_t either = segments[i].samples.size() + coverage.visible - coverage.shared[i];
      const double overlap = static_cast<double>(coverage.shared[i]) / static_cast<double>(either);
      if (overlap <= best[i]) continue;
      best[i] = overlap;
      matches[i] = place;
    }
  }
  return matches;
}

}  // namespace steadymap
