#include "core/association/gaps.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

namespace steadymap {
namespace {

// Most cells at an edge whose depth is unknown.
constexpr int kMaxEdgeCells = 2;

/// Returns the depths of the cells of a frame, one row after the other.
std::vector<float> DepthsByRow(const SemanticCloud& cloud) {
  std::vector<float> depths_m;
  depths_m.reserve(cloud.cells().size());
  for (const SurfaceCell& cell : cloud.cells()) depths_m.push_back(cell.depth_m);
  return depths_m;
}

/// Returns the same depths, one column after the other.
std::vector<float> DepthsByColumn(const std::vector<float>& by_row,
                                  std::size_t width,
                                  std::size_t height) {
  // In blocks, so that the cache lines of a block stay in the cache.
  constexpr std::size_t kBlock = 16;
  std::vector<float> by_column(by_row.size());
  for (std::size_t first_row = 0; first_row < height; first_row += kBlock) {
    const std::size_t end_row = std::min(first_row + kBlock, height);
    for (std::size_t column = 0; column < width; ++column) {
      for (std::size_t row = first_row; row < end_row; ++row) {
        by_column[column * height + row] = by_row[row * width + column];
      }
    }
  }
  return by_column;
}

/// The search for gaps along the rows or along the columns of cells of one frame.
class GapSearch {
 public:
  /// `depths_m` has the depth of each cell, one row after the other, or one column.
  GapSearch(const SemanticCloud& cloud,
            const GapParameters& parameters,
            bool along_rows,
            std::span<const float> depths_m)
      : cloud_(cloud),
        parameters_(parameters),
        along_rows_(along_rows),
        cells_(along_rows ? cloud.cells_wide() : cloud.cells_high()),
        focal_length_(along_rows ? cloud.camera().fx : cloud.camera().fy),
        depths_m_(depths_m),
        gaps_(static_cast<std::size_t>(along_rows ? cloud.cells_high() : cloud.cells_wide())) {}

  void AddGapsTo(std::vector<GapInView>* gaps) {
    for (std::size_t line = 0; line < gaps_.size(); ++line) Search(line);
    CountLines();
    for (std::size_t line = 0; line < gaps_.size(); ++line) {
      for (const Gap& gap : gaps_[line]) {
        if (gap.lines >= parameters_.min_lines) gaps->push_back(Describe(line, gap));
      }
    }
  }

 private:
  /// A gap on one line.
  struct Gap {
    int begin = 0;          ///< The last cell before it.
    int end = 0;            ///< The first cell behind it.
    double way_m = 0.0;     ///< Horizontal way of the ray behind both cells.
    std::size_t lines = 1;  ///< Number of consecutive lines that show it.
  };

  /// Returns the column and row of a cell.
  Eigen::Vector2i PlaceOf(std::size_t line, int cell) const {
    const auto other = static_cast<int>(line);
    return along_rows_ ? Eigen::Vector2i(cell, other) : Eigen::Vector2i(other, cell);
  }

  /// Returns the depth of a cell of the line that is searched.
  double DepthAt(int cell) const {
    return static_cast<double>(line_m_[static_cast<std::size_t>(cell)]);
  }

  /// Returns the ray (z = 1) of a cell in the axes of the world.
  Eigen::Vector3d RayAt(std::size_t line, int cell) const {
    const Eigen::Vector2i place = PlaceOf(line, cell);
    return cloud_.T_world_camera().linear() * cloud_.camera().Ray(place.x(), place.y());
  }

  Eigen::Vector3d PositionAt(std::size_t line, int cell) const {
    const Eigen::Vector2i place = PlaceOf(line, cell);
    const auto depth_m = static_cast<double>(cloud_.At(place.x(), place.y()).depth_m);
    return cloud_.T_world_camera().translation() + depth_m * RayAt(line, cell);
  }

  bool MayBeOneThing(std::size_t line, int a, int b) const {
    const Eigen::Vector2i at_a = PlaceOf(line, a);
    const Eigen::Vector2i at_b = PlaceOf(line, b);
    return cloud_.InstanceAt(at_a.x(), at_a.y()) == 0 &&
           cloud_.InstanceAt(at_b.x(), at_b.y()) == 0 &&
           cloud_.LabelAt(at_a.x(), at_a.y()) == cloud_.LabelAt(at_b.x(), at_b.y());
  }

  /// Returns the least difference of two depths that noise does not make.
  double StepAt(double depth_m) const {
    return parameters_.max_sigmas * M_SQRT2 * cloud_.CellSigmaM(depth_m);
  }

  void Search(std::size_t line) {
    const auto length = static_cast<std::size_t>(cells_);
    line_m_ = depths_m_.subspan(line * length, length);
    for (int begin = 0; begin + 1 < cells_; ++begin) {
      // Almost all cells go on to a next one that is as near.
      const double near_m = DepthAt(begin);
      const double next_m = DepthAt(begin + 1);
      if (next_m > 0.0 && (next_m <= near_m || next_m < near_m + StepAt(near_m))) continue;
      Gap gap;
      gap.begin = begin;
      if (!FindEnd(line, &gap)) continue;
      gaps_[line].push_back(gap);
      begin = gap.end - 1;
    }
  }

  /// Finds the end of a gap that begins after the cell `gap->begin`. False if there is none.
  bool FindEnd(std::size_t line, Gap* gap) const {
    const double near_m = DepthAt(gap->begin);
    if (!(near_m > 0.0)) return false;
    const double step_m = StepAt(near_m);
    // As a number: near the camera, the width has more cells than an integer counts.
    const double reach = parameters_.max_width_m * focal_length_ / near_m + 1.0;
    const int last = static_cast<int>(std::min(cells_ - 1.0, gap->begin + reach));
    double nearest_m = std::numeric_limits<double>::max();
    double deepest_m = 0.0;
    int deepest = 0;  // 0: no depth is known yet.
    for (int cell = gap->begin + 1; cell <= last; ++cell) {
      const double depth_m = DepthAt(cell);
      if (!(depth_m > 0.0)) {
        if (deepest == 0 && cell > gap->begin + kMaxEdgeCells) return false;
        continue;
      }
      if (deepest != 0 && depth_m < nearest_m && near_m < nearest_m) {
        gap->end = cell;
        gap->way_m =
            (deepest_m - std::max(near_m, depth_m)) * RayAt(line, deepest).head<2>().norm();
        if (deepest_m > std::max(near_m, depth_m) + StepAt(deepest_m) && IsGap(line, *gap)) {
          return true;
        }
      }
      if (depth_m < near_m + step_m) return false;
      nearest_m = std::min(nearest_m, depth_m);
      if (depth_m > deepest_m) {
        deepest_m = depth_m;
        deepest = cell;
      }
    }
    return false;
  }

  /// True if there is a gap between two cells beside each other.
  bool IsGap(std::size_t line, const Gap& gap) const {
    if (!MayBeOneThing(line, gap.begin, gap.end)) return false;
    const Eigen::Vector3d across_world = PositionAt(line, gap.end) - PositionAt(line, gap.begin);
    const double width_m = across_world.norm();
    return width_m <= parameters_.max_width_m && gap.way_m > width_m &&
           across_world.head<2>().norm() >= parameters_.min_level_cosine * width_m;
  }

  static bool Overlap(const Gap& a, const Gap& b) {
    return a.begin + 1 < b.end && b.begin + 1 < a.end;
  }

  void CountLines() {
    for (std::size_t line = 1; line < gaps_.size(); ++line) {
      for (Gap& gap : gaps_[line]) {
        for (const Gap& before : gaps_[line - 1]) {
          if (Overlap(gap, before)) gap.lines = std::max(gap.lines, before.lines + 1);
        }
      }
    }
    for (std::size_t line = gaps_.size(); line-- > 1;) {
      for (Gap& before : gaps_[line - 1]) {
        for (const Gap& gap : gaps_[line]) {
          if (Overlap(gap, before)) before.lines = std::max(before.lines, gap.lines);
        }
      }
    }
  }

  GapInView Describe(std::size_t line, const Gap& gap) const {
    const Eigen::Vector3d begin_world = PositionAt(line, gap.begin);
    const Eigen::Vector3d end_world = PositionAt(line, gap.end);
    GapInView in_view;
    in_view.begin = PlaceOf(line, gap.begin);
    in_view.end = PlaceOf(line, gap.end);
    in_view.middle_world = 0.5 * (begin_world + end_world);
    in_view.view_world =
        (in_view.middle_world - cloud_.T_world_camera().translation()).head<2>().normalized();
    in_view.width_m = (end_world - begin_world).norm();
    in_view.max_angle_rad = in_view.width_m / gap.way_m;
    return in_view;
  }

  const SemanticCloud& cloud_;
  const GapParameters& parameters_;
  bool along_rows_;
  int cells_;  ///< Of a line.
  double focal_length_;
  std::span<const float> depths_m_;     ///< Of all cells, by line.
  std::span<const float> line_m_;       ///< Of the cells of the line that is searched.
  std::vector<std::vector<Gap>> gaps_;  ///< By line.
};

}  // namespace

std::vector<GapInView> FindGaps(const SemanticCloud& cloud, const GapParameters& parameters) {
  std::vector<GapInView> gaps;
  const std::vector<float> by_row = DepthsByRow(cloud);
  GapSearch(cloud, parameters, /*along_rows=*/true, by_row).AddGapsTo(&gaps);
  const std::vector<float> by_column = DepthsByColumn(by_row,
                                                      static_cast<std::size_t>(cloud.cells_wide()),
                                                      static_cast<std::size_t>(cloud.cells_high()));
  GapSearch(cloud, parameters, /*along_rows=*/false, by_column).AddGapsTo(&gaps);
  return gaps;
}

}  // namespace steadymap
