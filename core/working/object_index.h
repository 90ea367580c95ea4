#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "core/geometry/geometry.h"
#include "core/types/identifiers.h"

namespace steadymap {

/// Where the objects of a map stand, so that a frame asks for those around it instead of all: a
/// grid of square cells over the world's x and y, each with the objects whose bounds reach into it.
///
/// Answers depend on the bounds alone, not on the cells nor on the order of updates.
class ObjectIndex {
 public:
  /// Side of a cell, metres: about what a camera sees at once. Smaller cells list large things more
  /// often, larger ones make a query look at more that it does not ask for.
  static constexpr double kCellM = 4.0;

  /// Bounds that cover more cells are kept apart, and every query looks at them: 28 m by 28 m.
  static constexpr std::size_t kMaxCells = 64;

  /// Says where an object stands now. Empty bounds are nowhere; those that are not finite, or
  /// larger than `kMaxCells`, are found all the same, as far as `Box::intersects` finds them.
  /// Cost: well below a microsecond as long as the object covers the same cells.
  void Update(ObjectId id, const Box& bounds_world);

  /// The object is gone; no harm if it was nowhere.
  void Erase(ObjectId id);

  /// The objects whose bounds meet the box (touching counts), by rising id, each once. None for an
  /// empty box. Cost: that of the objects in the cells that the box covers, and at most that of all
  /// objects, however large the box is.
  std::vector<ObjectId> Find(const Box& box_world) const;

  /// Where an object stands, as last said; empty if it is nowhere.
  Box BoundsOf(ObjectId id) const;

  /// Objects that stand somewhere.
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
  std::unordered_map<Cell, std::vector<ObjectId>, CellHash> cells_;  ///< No empty ones.
  std::vector<ObjectId> everywhere_;  ///< Those of too many cells, or too far away.
};

}  // namespace steadymap
