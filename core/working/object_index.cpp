#include "core/working/object_index.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace steadymap {
namespace {

// Largest index of a cell, far outside of any map (`kMaxPositionM`).
constexpr double kMaxCell = 1e6;

void Remove(ObjectId id, std::vector<ObjectId>* ids) {
  const auto place = std::find(ids->begin(), ids->end(), id);
  if (place == ids->end()) return;
  *place = ids->back();
  ids->pop_back();
}

}  // namespace

std::size_t ObjectIndex::CellHash::operator()(const Cell& cell) const noexcept {
  const std::uint64_t both = static_cast<std::uint64_t>(static_cast<std::uint32_t>(cell.x)) << 32 |
                             static_cast<std::uint32_t>(cell.y);
  return std::hash<std::uint64_t>()(both * 0x9E3779B97F4A7C15U);
}

std::size_t ObjectIndex::CellRange::count() const {
  const auto wide = static_cast<std::size_t>(std::int64_t{last.x} - first.x + 1);
  const auto high = static_cast<std::size_t>(std::int64_t{last.y} - first.y + 1);
  return wide * high;
}

/// Returns none if a coordinate is not finite or beyond `kMaxCell`.
std::optional<ObjectIndex::CellRange> ObjectIndex::CellsUnder(const Box& bounds_world) {
  const Eigen::Array2d low = (bounds_world.min().head<2>().array() / kCellM).floor();
  const Eigen::Array2d high = (bounds_world.max().head<2>().array() / kCellM).floor();
  // NaN fails the comparison.
  if (!((low.abs() <= kMaxCell).all() && (high.abs() <= kMaxCell).all())) {
    return std::nullopt;
  }
  const auto cell = [](const Eigen::Array2d& corner) {
    return Cell{static_cast<std::int32_t>(corner.x()), static_cast<std::int32_t>(corner.y())};
  };
  return CellRange{cell(low), cell(high)};
}

void ObjectIndex::Update(ObjectId id, const Box& bounds_world) {
  if (bounds_world.isEmpty()) {
    Erase(id);
    return;
  }
  std::optional<CellRange> cells = CellsUnder(bounds_world);
  if (cells && cells->count() > kMaxCells) cells.reset();
  const auto [place, is_new] = entries_.try_emplace(id);
  Entry& entry = place->second;
  entry.bounds_world = bounds_world;
  if (!is_new && entry.cells == cells) return;
  if (!is_new) Unlist(id, entry.cells);
  entry.cells = cells;
  List(id, cells);
}

void ObjectIndex::Erase(ObjectId id) {
  const auto entry = entries_.find(id);
  if (entry == entries_.end()) return;
  Unlist(id, entry->second.cells);
  entries_.erase(entry);
}

void ObjectIndex::List(ObjectId id, const std::optional<CellRange>& cells) {
  if (!cells) {
    everywhere_.push_back(id);
    return;
  }
  for (std::int32_t x = cells->first.x; x <= cells->last.x; ++x) {
    for (std::int32_t y = cells->first.y; y <= cells->last.y; ++y) cells_[{x, y}].push_back(id);
  }
}

void ObjectIndex::Unlist(ObjectId id, const std::optional<CellRange>& cells) {
  if (!cells) {
    Remove(id, &everywhere_);
    return;
  }
  for (std::int32_t x = cells->first.x; x <= cells->last.x; ++x) {
    for (std::int32_t y = cells->first.y; y <= cells->last.y; ++y) {
      const auto cell = cells_.find({x, y});
      Remove(id, &cell->second);
      if (cell->second.empty()) cells_.erase(cell);
    }
  }
}

Box ObjectIndex::BoundsOf(ObjectId id) const {
  const auto entry = entries_.find(id);
  return entry == entries_.end() ? Box() : entry->second.bounds_world;
}

std::vector<ObjectId> ObjectIndex::Find(const Box& box_world) const {
  std::vector<ObjectId> found;
  if (box_world.isEmpty()) return found;
  const auto take = [&](const std::vector<ObjectId>& ids) {
    for (const ObjectId id : ids) {
      if (entries_.at(id).bounds_world.intersects(box_world)) found.push_back(id);
    }
  };
  const std::optional<CellRange> range = CellsUnder(box_world);
  if (!range || range->count() > cells_.size()) {
    for (const auto& [id, entry] : entries_) {
      if (entry.bounds_world.intersects(box_world)) found.push_back(id);
    }
  } else {
    take(everywhere_);
    for (std::int32_t x = range->first.x; x <= range->last.x; ++x) {
      for (std::int32_t y = range->first.y; y <= range->last.y; ++y) {
        const auto cell = cells_.find({x, y});
        if (cell != cells_.end()) take(cell->second);
      }
    }
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

}  // namespace steadymap
