#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace steadymap {

/// A row and a column that may be matched, with the cost of the match.
struct AssignmentPair {
  std::size_t row = 0;
  std::size_t column = 0;
  double cost = 0.0;  ///< May be negative. A pair of infinite or NaN cost is ignored.
};

/// Computes the cheapest matching over sparse pairs. Each row is matched with at most one column,
/// and each column with at most one row. The sum of the costs of the chosen pairs, plus
/// `unmatched_cost` for each unmatched row, is minimal. Returns the column of each row, or none.
///
/// `pairs` contains rows below `row_count` and columns below `column_count` (asserted), in any
/// order. Of duplicates of a row and column, the cheapest counts. `unmatched_cost` is finite
/// (asserted). A pair is never chosen unless it is strictly cheaper than `unmatched_cost`. The
/// result is independent of the order of the pairs, even among matchings of equal cost.
///
/// Shortest augmenting paths along the pairs (Jonker and Volgenant, 1987). A path stays within a
/// connected component: a component of n rows and columns costs O(n^3), independent of the number
/// of components.
std::vector<std::optional<std::size_t>> AssignColumns(std::size_t row_count,
                                                      std::size_t column_count,
                                                      std::span<const AssignmentPair> pairs,
                                                      double unmatched_cost);

/// The same, but keeps only the unambiguous pairs: those without which the cheapest matching costs
/// more than `margin` (>= 0, asserted) more. Costs one `AssignColumns` for each matched row.
std::vector<std::optional<std::size_t>> AssignClearColumns(std::size_t row_count,
                                                           std::size_t column_count,
                                                           std::span<const AssignmentPair> pairs,
                                                           double unmatched_cost,
                                                           double margin);

}  // namespace steadymap
