#include "core/robot/dynamic_mask.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/geometry/cell_index.h"

namespace steadymap {
namespace {

// More than people and trucks around a robot show, so that a camera whose every pixel is called one
// fills no memory.
constexpr std::size_t kMaxCells = 4096;

/// Where the surface cell lies in the world, metres.
Eigen::Vector3d PositionAt(const SemanticCloud& cloud, int column, int row) {
  const auto depth_m = static_cast<double>(cloud.At(column, row).depth_m);
  return cloud.T_world_camera() * (depth_m * cloud.camera().Ray(column, row)).eval();
}

}  // namespace

DynamicMask::DynamicMask(const MapConfig& config, const DynamicMaskParameters& parameters)
    : parameters_(parameters), cell_size_m_(MapSnapshot::kFreeCellVoxels * config.voxel_size_m) {}

void DynamicMask::Apply(const SensorName& sensor,
                        const WorkingMap& map,
                        SemanticCloud* cloud) const {
  if (!parameters_.is_on) return;
  const RobotState* state = map.FindRobot(sensor);
  if (state == nullptr) return;
  std::vector<CellIndex> cells;
  Eigen::AlignedBox3d around_world;
  for (const MovingCell& moving : state->moving) {
    if (!moving.is_confirmed || !IsFresh(moving, map)) continue;
    cells.push_back(moving.cell);
    const Eigen::Vector3d low_cells(moving.cell.x, moving.cell.y, moving.cell.z);
    around_world.extend(cell_size_m_ * low_cells);
    around_world.extend(cell_size_m_ * (low_cells + Eigen::Vector3d::Ones()));
  }
  if (cells.empty()) return;
  for (int row = 0; row < cloud->cells_high(); ++row) {
    for (int column = 0; column < cloud->cells_wide(); ++column) {
      SurfaceCell& cell = cloud->MutableAt(column, row);
      if (!(cell.weight > 0.0F)) continue;
      const Eigen::Vector3d position_world = PositionAt(*cloud, column, row);
      if (around_world.contains(position_world) &&
          std::binary_search(cells.begin(), cells.end(), CellAt(position_world / cell_size_m_))) {
        cell.weight = 0.0F;
      }
    }
  }
}

void DynamicMask::Record(const SensorName& sensor,
                         const SemanticCloud& cloud,
                         WorkingMap* map) const {
  if (!parameters_.is_on) return;
  const RobotState* known = map->FindRobot(sensor);
  const std::vector<CellIndex> seen = CellsInSight(cloud);
  if (seen.empty() && (known == nullptr || known->moving.empty())) return;
  RobotState state = known == nullptr ? RobotState() : *known;
  std::erase_if(state.moving, [&](const MovingCell& moving) { return !IsFresh(moving, *map); });
  std::vector<MovingCell> merged;
  merged.reserve(std::min(state.moving.size() + seen.size(), kMaxCells));
  auto old = state.moving.begin();
  for (const CellIndex& cell : seen) {
    while (old != state.moving.end() && old->cell < cell) merged.push_back(*old++);
    const bool is_confirmed = old != state.moving.end() && old->cell == cell;
    if (is_confirmed) ++old;
    merged.push_back({cell, map->now(), is_confirmed});
  }
  merged.insert(merged.end(), old, state.moving.end());
  if (merged.size() > kMaxCells) merged.resize(kMaxCells);
  state.moving = std::move(merged);
  map->StoreRobot(sensor, state);
}

/// Frames may come late; the future of another is as far away as its past.
bool DynamicMask::IsFresh(const MovingCell& cell, const WorkingMap& map) const {
  return std::abs((map.now() - cell.seen).seconds()) <= parameters_.memory_s;
}

/// Where the cloud shows surface of dynamic classes; rising, none twice.
std::vector<CellIndex> DynamicMask::CellsInSight(const SemanticCloud& cloud) const {
  std::vector<CellIndex> cells;
  for (int row = 0; row < cloud.cells_high(); ++row) {
    for (int column = 0; column < cloud.cells_wide(); ++column) {
      if (!cloud.IsDynamicAt(column, row) || !(cloud.At(column, row).depth_m > 0.0F)) continue;
      const CellIndex cell = CellAt(PositionAt(cloud, column, row) / cell_size_m_);
      if (cells.empty() || cells.back() != cell) cells.push_back(cell);
    }
  }
  std::sort(cells.begin(), cells.end());
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  return cells;
}

}  // namespace steadymap
