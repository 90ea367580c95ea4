#include "core/change/no_return_labels.h"

#include <cstddef>

namespace steadymap {

NoReturnLabels::NoReturnLabels(const MapConfig& config) : stays_(config.label_limit(), 0) {
  for (const SemanticClass& row : config.classes) {
    const bool stays = row.id != ClassId(0) && row.motion == ClassMotion::kStatic;
    stays_[row.id.value()] = stays ? 1 : 0;
  }
}

void NoReturnLabels::Compute(const Frame& frame) {
  is_far_.clear();
  labels_ = &frame.labels;
  width_ = frame.labels.width_px() / MinDepthGrid::kTilePx;
  height_ = frame.labels.height_px() / MinDepthGrid::kTilePx;
  is_far_.reserve(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  for (int row = 0; row < height_; ++row) {
    for (int column = 0; column < width_; ++column) {
      is_far_.push_back(IsFar(frame, column, row) ? 1 : 0);
    }
  }
}

/// Whether nothing returns from a tile and all that it shows stays.
bool NoReturnLabels::IsFar(const Frame& frame, int column, int row) const {
  const int first_u = column * MinDepthGrid::kTilePx;
  const int first_v = row * MinDepthGrid::kTilePx;
  for (int v = first_v; v < first_v + MinDepthGrid::kTilePx; ++v) {
    for (int u = first_u; u < first_u + MinDepthGrid::kTilePx; ++u) {
      const std::uint16_t units = frame.depth.units.At(u, v);
      if (units != kNoDepth && units != kInvalidDepth) return false;
      const std::uint16_t label = frame.labels.At(u, v);
      if (label >= stays_.size() || stays_[label] == 0) return false;
    }
  }
  return true;
}

bool NoReturnLabels::ShowOther(ClassId class_id, int column, int row) const {
  if (column < 1 || row < 1 || column + 1 >= width_ || row + 1 >= height_) return false;
  for (int v = row - 1; v <= row + 1; ++v) {
    for (int u = column - 1; u <= column + 1; ++u) {
      const auto index = static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) +
                         static_cast<std::size_t>(u);
      if (is_far_[index] == 0) return false;
    }
  }
  for (int v = (row - 1) * MinDepthGrid::kTilePx; v < (row + 2) * MinDepthGrid::kTilePx; ++v) {
    for (int u = (column - 1) * MinDepthGrid::kTilePx; u < (column + 2) * MinDepthGrid::kTilePx;
         ++u) {
      if (labels_->At(u, v) == class_id.value()) return false;
    }
  }
  return true;
}

}  // namespace steadymap
