#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace steadymap {

/// A row and a column that may be matched with each other, and what that costs.
struct AssignmentPair {
  std::size_t row = 0;
  std::size_t column = 0;
  double cost = 0.0;  ///< May be negative. Infinity or NaN: may not be matched after all.
};

/// The cheapest matching over sparse pairs: each row gets a column or none, each column at most one
/// row, and the sum of the costs of the pairs chosen and of `unmatched_cost` for each row left over
/// is the least possible.
///
/// `pairs` hold rows below `row_count` and columns below `column_count`, in any order; of two of
/// the same row and column the cheaper counts. `unmatched_cost` is finite. A pair that is not
/// strictly cheaper than leaving its row over is never chosen. The result depends on the pairs
/// alone, not on their order, also where several matchings cost the same.
///
/// Shortest augmenting paths along the pairs (Jonker and Volgenant, 1987), which never leave a
/// connected component: components of n rows and columns cost O(n^3) each, no matter how many
/// there are.
std::vector<std::optional<std::size_t>> AssignColumns(std::size_t row_count,
                                                      std::size_t column_count,
                                                      std::span<const AssignmentPair> pairs,
                                                      double unmatched_cost);

}  // namespace steadymap
