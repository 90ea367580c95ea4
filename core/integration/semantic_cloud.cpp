#include "core/integration/semantic_cloud.h"

#include <algorithm>
#include <cstddef>
#include <map>

#include "core/integration/noise_scale.h"

namespace steadymap {

SemanticCloud::SemanticCloud(const MapConfig& config)
    : max_depth_m_(static_cast<float>(config.max_depth_m)),
      truncation_m_(static_cast<float>(config.truncation_m)),
      is_dynamic_(config.label_limit(), 0) {
  for (const SemanticClass& row : config.classes) {
    if (row.motion != ClassMotion::kDynamic) continue;
    is_dynamic_[row.id.value()] = 1;
    any_dynamic_ = true;
  }
}

void SemanticCloud::Compute(const Frame& frame) {
  T_world_camera_ = frame.T_world_camera;
  depth_noise_ = NoiseOf(frame.depth.sensor);
  // A camera may be noisier than is typical of its kind.
  const double scale = std::max(1.0, MeasureNoiseScale(frame.depth, depth_noise_));
  depth_noise_ = {scale * depth_noise_.floor_m, scale * depth_noise_.growth_per_m};
  has_color_ = !frame.color.empty();
  ComputeSurface(frame);
  TakeCorners(frame.labels, &labels_);
  TakeCorners(frame.instances, &instances_);
  DropDynamicClasses(frame);
  DropDynamicInstances();
  AddColors(frame);
}

void SemanticCloud::ComputeSurface(const Frame& frame) {
  const int width_px = frame.depth.units.width_px();
  const int height_px = frame.depth.units.height_px();
  if (cells_wide_ != width_px / 2 || cells_high_ != height_px / 2) {
    cells_wide_ = width_px / 2;
    cells_high_ = height_px / 2;
    const std::size_t padded = static_cast<std::size_t>(SurfaceStride(cells_wide_)) *
                               static_cast<std::size_t>(cells_high_ + 2 * kSurfaceMarginRows);
    inverse_depth_.assign(padded, 0.0F);
    support_.assign(padded, 0.0F);
    cells_.assign(static_cast<std::size_t>(cells_wide_) * static_cast<std::size_t>(cells_high_),
                  {});
    clearance_.assign(cells_.size(), 0);
    has_plane_.assign(cells_.size(), 0);
  }
  // The centre of a cell is the common corner of its four pixels, half a pixel from the centre of
  // the first.
  cell_camera_ = {cells_wide_,
                  cells_high_,
                  frame.camera.fx / 2.0,
                  frame.camera.fy / 2.0,
                  (frame.camera.cx - 0.5) / 2.0,
                  (frame.camera.cy - 0.5) / 2.0};
  kernels_.compute_surface({frame.depth.units.data(),
                            width_px,
                            height_px,
                            static_cast<float>(frame.depth.metres_per_unit),
                            max_depth_m_,
                            truncation_m_,
                            ForKernel(depth_noise_),
                            static_cast<float>(cell_camera_.fx),
                            static_cast<float>(cell_camera_.fy),
                            static_cast<float>(cell_camera_.cx),
                            static_cast<float>(cell_camera_.cy)},
                           {inverse_depth_.data(),
                            support_.data(),
                            cells_.data(),
                            clearance_.data(),
                            has_plane_.data()});
}

void SemanticCloud::DropDynamicClasses(const Frame& frame) {
  if (frame.labels.empty() || !any_dynamic_) return;
  for (int row = 0; row < cells_high_; ++row) {
    const std::uint16_t* upper = &frame.labels.At(0, 2 * row);
    const std::uint16_t* lower = &frame.labels.At(0, 2 * row + 1);
    SurfaceCell* row_cells = cells_.data() + Index(0, row);
    for (int column = 0; column < cells_wide_; ++column) {
      const int u = 2 * column;
      if ((is_dynamic_[upper[u]] | is_dynamic_[upper[u + 1]] | is_dynamic_[lower[u]] |
           is_dynamic_[lower[u + 1]]) != 0) {
        row_cells[column].weight = 0.0F;
      }
    }
  }
}

/// Regions of another class on a dynamic instance move with it.
void SemanticCloud::DropDynamicInstances() {
  if (labels_.empty() || instances_.empty() || !any_dynamic_) return;
  std::map<std::uint16_t, std::ptrdiff_t> majority;  // Dynamic minus other cells.
  for (std::size_t i = 0; i < instances_.size(); ++i) {
    if (instances_[i] != 0) majority[instances_[i]] += is_dynamic_[labels_[i]] != 0 ? 1 : -1;
  }
  std::erase_if(majority, [](const auto& instance) { return instance.second <= 0; });
  if (majority.empty()) return;
  for (std::size_t i = 0; i < instances_.size(); ++i) {
    if (majority.contains(instances_[i])) cells_[i].weight = 0.0F;
  }
}

void SemanticCloud::AddColors(const Frame& frame) {
  if (frame.color.empty()) return;
  for (int row = 0; row < cells_high_; ++row) {
    const Rgb* pixels = &frame.color.At(0, 2 * row);
    SurfaceCell* row_cells = cells_.data() + Index(0, row);
    for (int column = 0; column < cells_wide_; ++column) {
      const Rgb& rgb = pixels[2 * static_cast<std::size_t>(column)];
      row_cells[column].color = static_cast<std::uint32_t>(rgb[0]) |
                                static_cast<std::uint32_t>(rgb[1]) << 8 |
                                static_cast<std::uint32_t>(rgb[2]) << 16 | 0xFF000000U;
    }
  }
}

void SemanticCloud::TakeCorners(const Image<std::uint16_t>& image,
                                std::vector<std::uint16_t>* corners) const {
  corners->clear();
  if (image.empty()) return;
  corners->resize(cells_.size());
  for (int row = 0; row < cells_high_; ++row) {
    const std::uint16_t* pixels = &image.At(0, 2 * row);
    std::uint16_t* row_corners = corners->data() + Index(0, row);
    for (int column = 0; column < cells_wide_; ++column) {
      row_corners[column] = pixels[2 * static_cast<std::size_t>(column)];
    }
  }
}

}  // namespace steadymap
