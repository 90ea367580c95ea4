#include "core/free_space.h"

#include <cmath>

namespace steadymap {
namespace {

struct CellIndex {
  std::int32_t x;
  std::int32_t y;
  std::int32_t z;
};

CellIndex CellOf(const Eigen::Vector3d& point_cells) {
  return {static_cast<std::int32_t>(std::floor(point_cells.x())),
          static_cast<std::int32_t>(std::floor(point_cells.y())),
          static_cast<std::int32_t>(std::floor(point_cells.z()))};
}

}  // namespace

bool FreeSpace::IsFree(const Eigen::Vector3d& point_world) const {
  const CellIndex cell = CellOf(point_world / cell_size_m_);
  const auto block = blocks_.find(LeafOf(cell.x, cell.y, cell.z));
  return block != blocks_.end() && IsSet(block->second, OffsetInLeaf(cell.x, cell.y, cell.z));
}

void FreeSpace::MarkRay(const Eigen::Vector3d& from_world,
                        const Eigen::Vector3d& to_world,
                        std::vector<LeafOrigin>* changed_blocks) {
  const Eigen::Vector3d from_cells = from_world / cell_size_m_;
  const Eigen::Vector3d way_cells = to_world / cell_size_m_ - from_cells;
  // Steps of one cell: a ray may cut a corner unseen, the next ray will not.
  const auto steps = static_cast<int>(way_cells.norm());
  const Eigen::Vector3d step_cells = way_cells / std::max(steps, 1);
  Eigen::Vector3d point_cells = from_cells;
  LeafOrigin block_origin{1, 0, 0};  // Of no block.
  LeafMask* block = nullptr;
  for (int i = 0; i <= steps; ++i, point_cells += step_cells) {
    const CellIndex cell = CellOf(point_cells);
    const LeafOrigin origin = LeafOf(cell.x, cell.y, cell.z);
    if (origin != block_origin) {
      block_origin = origin;
      block = &blocks_[origin];
    }
    const std::size_t offset = OffsetInLeaf(cell.x, cell.y, cell.z);
    std::uint64_t& word = (*block)[offset >> 6];
    const std::uint64_t bit = std::uint64_t{1} << (offset & 63);
    if ((word & bit) != 0) continue;
    word |= bit;
    if (changed_blocks->empty() || changed_blocks->back() != origin) {
      changed_blocks->push_back(origin);
    }
  }
}

}  // namespace steadymap
