#include "core/geometry/assignment.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace steadymap {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Returns the pairs that can be part of an optimal matching, by row, then column, without
/// duplicates.
std::vector<AssignmentPair> UsefulPairs(std::span<const AssignmentPair> pairs,
                                        double unmatched_cost) {
  std::vector<AssignmentPair> useful;
  useful.reserve(pairs.size());
  for (const AssignmentPair& pair : pairs) {
    // A row can be left unmatched in every matching, so a more expensive pair is never useful.
    if (std::isfinite(pair.cost) && pair.cost < unmatched_cost) useful.push_back(pair);
  }
  std::sort(useful.begin(), useful.end(), [](const AssignmentPair& a, const AssignmentPair& b) {
    return std::tie(a.row, a.column, a.cost) < std::tie(b.row, b.column, b.cost);
  });
  const auto same_place = [](const AssignmentPair& a, const AssignmentPair& b) {
    return a.row == b.row && a.column == b.column;
  };
  useful.erase(std::unique(useful.begin(), useful.end(), same_place), useful.end());
  return useful;
}

/// Inserts the rows one by one, each along the cheapest path that ends at a free column or leaves a
/// row unmatched instead.
///
/// Invariant (complementary slackness), where u and v are the duals: `cost - u[row] - v[column]` is
/// >= 0 for each pair of an inserted row, and 0 for a matched pair. `unmatched_cost - u[row]` is >=
/// 0, and 0 for an unmatched row. v is 0 for a free column.
class Matching {
 public:
  Matching(std::size_t row_count,
           std::size_t column_count,
           std::vector<AssignmentPair> pairs,
           double unmatched_cost)
      : pairs_(std::move(pairs)),
        unmatched_cost_(unmatched_cost),
        rows_(row_count),
        columns_(column_count),
        column_of_row_(row_count) {
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      assert(pairs_[i].row < row_count && pairs_[i].column < column_count);
      Row& row = rows_[pairs_[i].row];
      if (row.pair_count++ == 0) row.first_pair = i;
    }
  }

  void Insert(std::size_t row);

  std::vector<std::optional<std::size_t>> TakeColumns() && { return std::move(column_of_row_); }

 private:
  struct Row {
    std::size_t first_pair = 0;
    std::size_t pair_count = 0;
    double dual = 0.0;
  };

  struct Column {
    std::optional<std::size_t> row;
    double dual = 0.0;
    // State of the current search.
    double distance = kInfinity;
    std::size_t previous_row = 0;
    bool settled = false;
  };

  /// A possible end of a path, with the length of the path.
  struct PathEnd {
    double distance = kInfinity;
    std::optional<std::size_t> free_column;
    std::size_t left_over_row = 0;
  };

  PathEnd FindPath(std::size_t start_row);
  void Relax(std::size_t row, double distance);
  std::optional<std::size_t> NearestOpenColumn() const;
  void UpdateDuals(std::size_t start_row, double distance);
  void Rematch(const PathEnd& end);

  std::vector<AssignmentPair> pairs_;
  double unmatched_cost_;
  std::vector<Row> rows_;
  std::vector<Column> columns_;
  std::vector<std::optional<std::size_t>> column_of_row_;
  std::vector<std::size_t> reached_;  ///< Columns reached in the current search.
};

void Matching::Insert(std::size_t row) {
  const PathEnd end = FindPath(row);
  UpdateDuals(row, end.distance);
  Rematch(end);
  for (const std::size_t column : reached_) {
    columns_[column].distance = kInfinity;
    columns_[column].settled = false;
  }
  reached_.clear();
}

Matching::PathEnd Matching::FindPath(std::size_t start_row) {
  PathEnd end;
  std::size_t row = start_row;
  double distance = 0.0;
  while (true) {
    const double left_over = distance + unmatched_cost_ - rows_[row].dual;
    if (left_over < end.distance) end = {left_over, std::nullopt, row};
    Relax(row, distance);
    const std::optional<std::size_t> nearest = NearestOpenColumn();
    if (!nearest || columns_[*nearest].distance >= end.distance) return end;
    Column& column = columns_[*nearest];
    distance = column.distance;
    if (!column.row) return {distance, nearest, row};
    column.settled = true;
    row = *column.row;
  }
}

void Matching::Relax(std::size_t row, double distance) {
  const Row& from = rows_[row];
  for (const AssignmentPair& pair : std::span(pairs_).subspan(from.first_pair, from.pair_count)) {
    Column& column = columns_[pair.column];
    if (column.settled) continue;
    const double through_row = distance + pair.cost - from.dual - column.dual;
    if (through_row >= column.distance) continue;
    if (column.distance == kInfinity) reached_.push_back(pair.column);
    column.distance = through_row;
    column.previous_row = row;
  }
}

std::optional<std::size_t> Matching::NearestOpenColumn() const {
  std::optional<std::size_t> nearest;
  for (const std::size_t column : reached_) {
    if (columns_[column].settled) continue;
    if (!nearest || columns_[column].distance < columns_[*nearest].distance) nearest = column;
  }
  return nearest;
}

void Matching::UpdateDuals(std::size_t start_row, double distance) {
  rows_[start_row].dual += distance;
  for (const std::size_t reached : reached_) {
    Column& column = columns_[reached];
    if (!column.settled) continue;
    rows_[*column.row].dual += distance - column.distance;
    column.dual -= distance - column.distance;
  }
}

void Matching::Rematch(const PathEnd& end) {
  std::optional<std::size_t> given_up = end.free_column;
  if (!given_up) given_up = std::exchange(column_of_row_[end.left_over_row], std::nullopt);
  // Backwards along the path, each row takes the column released by the next row. The inserted row
  // is the last and has no column to release.
  while (given_up) {
    const std::size_t column = *given_up;
    const std::size_t row = columns_[column].previous_row;
    columns_[column].row = row;
    given_up = std::exchange(column_of_row_[row], column);
  }
}

/// Returns the cost of a matching.
double TotalCostOf(const std::vector<std::optional<std::size_t>>& columns,
                   std::span<const AssignmentPair> pairs,
                   double unmatched_cost) {
  double total = 0.0;
  for (const auto& column : columns) total += column ? 0.0 : unmatched_cost;
  for (const AssignmentPair& pair : UsefulPairs(pairs, unmatched_cost)) {
    if (columns[pair.row] == pair.column) total += pair.cost;
  }
  return total;
}

}  // namespace

std::vector<std::optional<std::size_t>> AssignColumns(std::size_t row_count,
                                                      std::size_t column_count,
                                                      std::span<const AssignmentPair> pairs,
                                                      double unmatched_cost) {
  assert(std::isfinite(unmatched_cost));
  Matching matching(row_count, column_count, UsefulPairs(pairs, unmatched_cost), unmatched_cost);
  for (std::size_t row = 0; row < row_count; ++row) matching.Insert(row);
  return std::move(matching).TakeColumns();
}

std::vector<std::optional<std::size_t>> AssignClearColumns(std::size_t row_count,
                                                           std::size_t column_count,
                                                           std::span<const AssignmentPair> pairs,
                                                           double unmatched_cost,
                                                           double margin) {
  assert(margin >= 0.0);
  const std::vector<std::optional<std::size_t>> columns =
      AssignColumns(row_count, column_count, pairs, unmatched_cost);
  const double cost = TotalCostOf(columns, pairs, unmatched_cost);
  std::vector<std::optional<std::size_t>> clear(row_count);
  for (std::size_t row = 0; row < row_count; ++row) {
    if (!columns[row]) continue;
    std::vector<AssignmentPair> others(pairs.begin(), pairs.end());
    std::erase_if(others, [&](const AssignmentPair& pair) {
      return pair.row == row && pair.column == *columns[row];
    });
    const double other_cost = TotalCostOf(
        AssignColumns(row_count, column_count, others, unmatched_cost), others, unmatched_cost);
    if (other_cost - cost > margin) clear[row] = columns[row];
  }
  return clear;
}

}  // namespace steadymap
