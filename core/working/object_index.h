#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "core/geometry/geometry.h"
#include "core/types/identifiers.h"

namespace steadymap {

/// A spatial index of the objects of a map: a grid of square cells over the world's xy plane, each
/// with the objects whose bounds intersect it. A frame then accesses only the objects around it.
///
/// Results depend only on the bounds, not on the cells or the order of updates.
class ObjectIndex {
 public:
  /// Side of a cell, metres: about the extent of a camera's view. With smaller cells large objects
  /// have more entries; with larger cells a query inspects more objects outside of its box.
  static constexpr double kCellM = 4.0;

  /// Objects with bounds over more cells are stored in a separate list, which every query inspects:
  /// 28 m by 28 m.
  static constexpr std::size_t kMaxCells = 64;

  /// Sets the bounds of an object. Empty bounds remove it. Bounds that are not finite, or cover
  /// more than `kMaxCells` cells, are also found as far as `Box::intersects` is true. Cost: well
  /// below a microsecond if the object stays in the same cells.
  void Update(ObjectId id, const Box& bounds_world);

  /// Removes an object. No effect if it has no bounds.
  void Erase(ObjectId id);

  /// Returns the objects whose bounds intersect the box, borders included, by increasing id, each
  /// once. An empty box gives none. Cost: proportional to the objects in the cells of the box, and
  /// at most to all objects, for a box of any size.
  std::vector<ObjectId> Find(const Box& box_world) const;

  /// Returns the bounds of an object as last set; empty if it has none.
  Box BoundsOf(ObjectId id) const;

  /// Returns the number of objects with bounds.
  std::size_t size() const { return entries_.size(); }

 private:
  struct Cell {
    std::int32_t x = 0;
    std::int32_t y = 0;
    friend constexpr bool operator==(const Cell&, const Cell&) = default;
  };

  struct CellHash {
    std::size_t operator()(const Cell& cell) const noexcept;
  };

  /// The cells from `first` to `last`, both included.
  struct CellRange {
    Cell first;
    Cell last;

    friend constexpr bool operator==(const CellRange&, const CellRange&) = default;

    std::size_t count() const;
  };

  struct Entry {
    Box bounds_world;
    std::optional<CellRange> cells;  ///< None: in `everywhere_`.
  };

  static std::optional<CellRange> CellsUnder(const Box& bounds_world);
  void List(ObjectId id, const std::optional<CellRange>& cells);
  void Unlist(ObjectId id, const std::optional<CellRange>& cells);

  std::unordered_map<ObjectId, Entry> entries_;
  std::unordered_map<Cell, std::vector<ObjectId>, CellHash> cells_;  ///< Without empty cells.
  std::vector<ObjectId> everywhere_;  ///< Objects over too many cells, or too far away.
};

}  // namespace steadymap
