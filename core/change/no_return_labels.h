#pragma once

#include <cstdint>
#include <vector>

#include "core/change/min_depth_grid.h"
#include "core/frame/frame.h"
#include "core/types/map_config.h"

namespace steadymap {

/// What a frame shows beyond the reach of its depth, by the same tiles as `MinDepthGrid`: where
/// nothing returns, labels of classes that stay tell of a wall or a ceiling far away.
///
/// Glare and glass give no depth either, but keep the label of their thing. What class 0 and
/// dynamic classes show may be anything near.
class NoReturnLabels {
 public:
  /// Takes the classes that stay from `config`.
  explicit NoReturnLabels(const MapConfig& config);

  /// `frame` must outlive the questions about it.
  void Compute(const Frame& frame);

  /// Whether a tile and its eight neighbours show what is far away, and nothing of `class_id`.
  bool ShowOther(ClassId class_id, int column, int row) const;

 private:
  bool IsFar(const Frame& frame, int column, int row) const;

  std::vector<std::uint8_t> stays_;  ///< By label.
  const Image<std::uint16_t>* labels_ = nullptr;
  int width_ = 0;
  int height_ = 0;
  std::vector<std::uint8_t> is_far_;  ///< By tile.
};

}  // namespace steadymap
