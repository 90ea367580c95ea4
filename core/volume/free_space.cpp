#include "core/volume/free_space.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "core/geometry/cell_index.h"

namespace steadymap {
namespace {

/// Enumerates all cells along a ray, in order (Amanatides and Woo, "A fast voxel traversal
/// algorithm", 1987). Lengths in cells.
class CellWalk {
 public:
  CellWalk(const Eigen::Vector3d& start, const Eigen::Vector3d& unit_direction)
      : cell_(CellAt(start)) {
    const std::array<std::int32_t, 3> first = {cell_.x, cell_.y, cell_.z};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double along = unit_direction[static_cast<Eigen::Index>(axis)];
      if (along == 0.0) continue;
      const double border = first[axis] + (along > 0.0 ? 1 : 0);
      sign_[axis] = along > 0.0 ? 1 : -1;
      until_border_[axis] = (border - start[static_cast<Eigen::Index>(axis)]) / along;
      per_cell_[axis] = 1.0 / std::abs(along);
    }
  }

  const CellIndex& cell() const { return cell_; }

  /// Returns the distance from the start to the entry into the cell.
  double entry_cells() const { return entry_; }

  void Advance() {
    const auto nearest = std::min_element(until_border_.begin(), until_border_.end());
    const auto axis = static_cast<std::size_t>(nearest - until_border_.begin());
    entry_ = until_border_[axis];
    until_border_[axis] += per_cell_[axis];
    (axis == 0 ? cell_.x : axis == 1 ? cell_.y : cell_.z) += sign_[axis];
  }

 private:
  static constexpr double kNever = std::numeric_limits<double>::infinity();

  CellIndex cell_;
  double entry_ = 0.0;
  std::array<std::int32_t, 3> sign_{};
  std::array<double, 3> until_border_ = {kNever, kNever, kNever};  ///< From the start.
  std::array<double, 3> per_cell_{};
};

}  // namespace

LeafOrigin FreeSpace::TileOf(LeafOrigin block) {
  static_assert((kTileSide & (kTileSide - 1)) == 0, "the mask below needs a power of two");
  constexpr std::int32_t kTileMask = ~(kTileSide - 1);
  return {block.x & kTileMask, block.y & kTileMask, block.z & kTileMask};
}

std::size_t FreeSpace::PlaceInTile(LeafOrigin block) {
  const auto place = [](std::int32_t cell) {
    return static_cast<std::size_t>((cell & (kTileSide - 1)) / kLeafSide);
  };
  return (place(block.x) * kTileBlocks + place(block.y)) * kTileBlocks + place(block.z);
}

FreeBlock FreeSpace::FindBlock(LeafOrigin origin) const {
  const auto tile = tiles_.find(TileOf(origin));
  return tile == tiles_.end() ? FreeBlock() : (*tile->second)[PlaceInTile(origin)];
}

FreeBlock& FreeSpace::MutableBlock(LeafOrigin origin) {
  std::shared_ptr<Tile>& tile = tiles_[TileOf(origin)];
  if (tile == nullptr) {
    tile = std::make_shared<Tile>();
  } else if (tile.use_count() > 1) {
    tile = std::make_shared<Tile>(*tile);
  }
  return (*tile)[PlaceInTile(origin)];
}

void FreeSpace::ForEachBlock(const std::function<void(LeafOrigin, const FreeBlock&)>& visit) const {
  for (const auto& [lowest, tile] : tiles_) {
    for (std::size_t place = 0; place < tile->size(); ++place) {
      if ((*tile)[place].cells == LeafMask{}) continue;
      const auto index = static_cast<std::int32_t>(place);
      visit({lowest.x + index / (kTileBlocks * kTileBlocks) * kLeafSide,
             lowest.y + index / kTileBlocks % kTileBlocks * kLeafSide,
             lowest.z + index % kTileBlocks * kLeafSide},
            (*tile)[place]);
    }
  }
}

bool operator==(const FreeSpace& a, const FreeSpace& b) {
  if (a.cell_size_m_ != b.cell_size_m_) return false;
  const auto covers = [](const FreeSpace& whole, const FreeSpace& part) {
    bool is_covered = true;
    part.ForEachBlock([&](LeafOrigin origin, const FreeBlock& block) {
      is_covered = is_covered && whole.FindBlock(origin) == block;
    });
    return is_covered;
  };
  return covers(a, b) && covers(b, a);
}

bool FreeSpace::IsFree(const Eigen::Vector3d& point_world) const {
  const CellIndex cell = CellAt(point_world / cell_size_m_);
  const FreeBlock block = FindBlock(LeafOf(cell.x, cell.y, cell.z));
  return IsSet(block.cells, OffsetInLeaf(cell.x, cell.y, cell.z));
}

bool FreeSpace::IsFreeSince(const Eigen::Vector3d& point_world, Timestamp time) const {
  const CellIndex cell = CellAt(point_world / cell_size_m_);
  const FreeBlock block = FindBlock(LeafOf(cell.x, cell.y, cell.z));
  return block.recent_since >= time && IsSet(block.recent, OffsetInLeaf(cell.x, cell.y, cell.z));
}

Box FreeSpace::Bounds() const {
  Box bounds;
  for (const auto& [lowest, tile] : tiles_) {
    const Eigen::Array3d low(lowest.x, lowest.y, lowest.z);
    bounds.extend(Eigen::Vector3d(cell_size_m_ * low));
    bounds.extend(Eigen::Vector3d(cell_size_m_ * (low + kTileSide)));
  }
  return bounds;
}

double FreeSpace::FreeRun(const Eigen::Vector3d& start_world,
                          const Eigen::Vector3d& unit_direction_world,
                          double max_m,
                          QueryWork* work) const {
  CellWalk walk(start_world / cell_size_m_, unit_direction_world);
  const double max_cells = max_m / cell_size_m_;
  LeafOrigin block_origin{1, 0, 0};  // Not the origin of any block.
  LeafMask block{};
  while (walk.entry_cells() < max_cells) {
    const CellIndex& cell = walk.cell();
    const LeafOrigin origin = LeafOf(cell.x, cell.y, cell.z);
    if (origin != block_origin) {
      if (!work->Take()) break;
      block_origin = origin;
      block = FindBlock(origin).cells;
    }
    if (!IsSet(block, OffsetInLeaf(cell.x, cell.y, cell.z))) break;
    walk.Advance();
  }
  return std::min(walk.entry_cells() * cell_size_m_, max_m);
}

void FreeSpace::MarkRay(const Eigen::Vector3d& from_world,
                        const Eigen::Vector3d& to_world,
                        const RayTime& ray_time,
                        std::vector<LeafOrigin>* changed_blocks) {
  const Eigen::Vector3d from_cells = from_world / cell_size_m_;
  const Eigen::Vector3d way_cells = to_world / cell_size_m_ - from_cells;
  // Steps of about one cell. A ray can skip a cell that it crosses near a corner; a neighbouring
  // ray marks it.
  const auto steps = static_cast<int>(way_cells.norm());
  const Eigen::Vector3d step_cells = way_cells / std::max(steps, 1);
  Eigen::Vector3d point_cells = from_cells;
  LeafOrigin block_origin{1, 0, 0};  // Not the origin of any block.
  FreeBlock block;
  bool is_recent = false;
  for (int i = 0; i <= steps; ++i, point_cells += step_cells) {
    const CellIndex cell = CellAt(point_cells);
    const LeafOrigin origin = LeafOf(cell.x, cell.y, cell.z);
    if (origin != block_origin) {
      block_origin = origin;
      block = FindBlock(origin);
      if (ray_time.session_start > block.recent_since && ray_time.session_start <= ray_time.time) {
        block.recent = {};
        block.recent_since = ray_time.session_start;
      }
      is_recent = ray_time.time >= block.recent_since;
    }
    const std::size_t offset = OffsetInLeaf(cell.x, cell.y, cell.z);
    if (IsSet(block.cells, offset) && (!is_recent || IsSet(block.recent, offset))) continue;
    SetBit(offset, &block.cells);
    if (is_recent) SetBit(offset, &block.recent);
    MutableBlock(origin) = block;
    if (changed_blocks->empty() || changed_blocks->back() != origin) {
      changed_blocks->push_back(origin);
    }
  }
}

}  // namespace steadymap
