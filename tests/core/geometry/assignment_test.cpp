// Oracle: exhaustive search over all matchings of a small problem.

#include "core/geometry/assignment.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "tests/support/special_numbers.h"

namespace steadymap {
namespace {

using ::steadymap::testing::kInfinity;
using ::steadymap::testing::kNan;

using Columns = std::vector<std::optional<std::size_t>>;

struct Problem {
  std::size_t row_count = 0;
  std::size_t column_count = 0;
  std::vector<AssignmentPair> pairs;
  double unmatched_cost = 1.0;
};

Columns Solve(const Problem& problem) {
  return AssignColumns(
      problem.row_count, problem.column_count, problem.pairs, problem.unmatched_cost);
}

/// Returns the cost of the cheapest pair of `row` and `column`, or infinity if they have no pair.
double CostOf(const Problem& problem, std::size_t row, std::size_t column) {
  double cost = kInfinity;
  for (const AssignmentPair& pair : problem.pairs) {
    if (pair.row == row && pair.column == column && pair.cost < cost) cost = pair.cost;
  }
  return cost;
}

/// Returns the total cost of a matching. Fails the test if the matching is invalid.
double TotalCost(const Problem& problem, const Columns& columns) {
  EXPECT_EQ(columns.size(), problem.row_count);
  std::set<std::size_t> taken;
  double total = 0.0;
  for (std::size_t row = 0; row < columns.size(); ++row) {
    if (!columns[row]) {
      total += problem.unmatched_cost;
      continue;
    }
    EXPECT_TRUE(taken.insert(*columns[row]).second) << "two rows share a column";
    const double cost = CostOf(problem, row, *columns[row]);
    EXPECT_LT(cost, problem.unmatched_cost);
    total += cost;
  }
  return total;
}

/// Returns the minimum total cost over the rows from `row` on, given the columns already taken.
double LeastCost(const Problem& problem, std::size_t row, std::vector<bool>* taken) {
  if (row == problem.row_count) return 0.0;
  double least = problem.unmatched_cost + LeastCost(problem, row + 1, taken);
  for (std::size_t column = 0; column < problem.column_count; ++column) {
    const double cost = CostOf(problem, row, column);
    if ((*taken)[column] || cost == kInfinity) continue;
    (*taken)[column] = true;
    least = std::min(least, cost + LeastCost(problem, row + 1, taken));
    (*taken)[column] = false;
  }
  return least;
}

double LeastCost(const Problem& problem) {
  std::vector<bool> taken(problem.column_count);
  return LeastCost(problem, 0, &taken);
}

/// Returns a problem with costs on a coarse grid, to produce many ties, or uniform in [-2, 4].
Problem RandomProblem(std::size_t most_per_side, bool with_ties, std::mt19937* random) {
  std::uniform_int_distribution<std::size_t> count(0, most_per_side);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  std::uniform_real_distribution<double> cost(-2.0, 4.0);
  Problem problem{count(*random), count(*random), {}, cost(*random)};
  const double density = share(*random);
  for (std::size_t row = 0; row < problem.row_count; ++row) {
    for (std::size_t column = 0; column < problem.column_count; ++column) {
      while (share(*random) < 0.9 * density) {
        const double any = share(*random) < 0.05 ? kInfinity : cost(*random);
        problem.pairs.push_back({row, column, with_ties ? std::round(any) : any});
      }
    }
  }
  if (with_ties) problem.unmatched_cost = std::round(problem.unmatched_cost);
  std::shuffle(problem.pairs.begin(), problem.pairs.end(), *random);
  return problem;
}

TEST(AssignColumns, AsCheapAsTheBestOfAllMatchings) {
  std::mt19937 random(1);
  for (int round = 0; round < 4000; ++round) {
    const Problem problem = RandomProblem(5, /*with_ties=*/round % 2 == 0, &random);
    ASSERT_NEAR(TotalCost(problem, Solve(problem)), LeastCost(problem), 1e-9) << "round " << round;
    ASSERT_FALSE(HasFailure()) << "round " << round;
  }
}

TEST(AssignColumns, OrderOfPairsDoesNotMatter) {
  std::mt19937 random(2);
  for (int round = 0; round < 500; ++round) {
    Problem problem = RandomProblem(8, /*with_ties=*/true, &random);
    const Columns first = Solve(problem);
    std::shuffle(problem.pairs.begin(), problem.pairs.end(), random);
    ASSERT_EQ(Solve(problem), first) << "round " << round;
  }
}

TEST(AssignColumns, NothingToMatch) {
  EXPECT_EQ(AssignColumns(0, 0, {}, 1.0), Columns());
  EXPECT_EQ(AssignColumns(0, 3, {}, 1.0), Columns());
  EXPECT_EQ(AssignColumns(2, 0, {}, 1.0), Columns(2));
  EXPECT_EQ(AssignColumns(2, 3, {}, 1.0), Columns(2));
}

TEST(AssignColumns, RowGivesItsColumnUpToOneThatNeedsItMore) {
  const Problem problem{2, 2, {{0, 0, 0.1}, {0, 1, 0.3}, {1, 0, 0.2}}, 10.0};
  EXPECT_EQ(Solve(problem), (Columns{1, 0}));
}

TEST(AssignColumns, EarlierRowIsLeftOverWhereThatIsCheaper) {
  const Problem problem{2, 1, {{0, 0, 0.5}, {1, 0, 0.2}}, 1.0};
  EXPECT_EQ(Solve(problem), (Columns{std::nullopt, 0}));
}

TEST(AssignColumns, PairAsDearAsLeavingOverIsNotChosen) {
  const Problem problem{2, 2, {{0, 0, 1.0}, {1, 1, 0.999}}, 1.0};
  EXPECT_EQ(Solve(problem), (Columns{std::nullopt, 1}));
}

TEST(AssignColumns, CheaperOfTwinPairsCounts) {
  const Problem problem{1, 2, {{0, 0, 0.9}, {0, 1, 0.5}, {0, 0, 0.1}}, 1.0};
  EXPECT_EQ(Solve(problem), (Columns{0}));
}

TEST(AssignColumns, PairsThatAreNotFiniteAreNotAllowed) {
  const Problem problem{3, 3, {{0, 0, kInfinity}, {1, 1, kNan}, {2, 2, -kInfinity}}, 1.0};
  EXPECT_EQ(Solve(problem), Columns(3));
}

TEST(AssignColumns, FindsTheDiagonalOfALargeComponent) {
  constexpr std::size_t kSide = 200;
  // The minimum is on the diagonal, by the rearrangement inequality. Greedy choices miss it.
  Problem problem{kSide, kSide, {}, 1e6};
  for (std::size_t row = 0; row < kSide; ++row) {
    for (std::size_t column = 0; column < kSide; ++column) {
      const double product = static_cast<double>(row) * static_cast<double>(column);
      problem.pairs.push_back({row, column, -product});
    }
  }
  const Columns columns = Solve(problem);
  for (std::size_t row = 0; row < kSide; ++row) ASSERT_EQ(columns[row], row);
}

TEST(AssignColumns, ShiftsALongChainByOne) {
  constexpr std::size_t kRows = 2000;
  // Each row except the last prefers its own column. The last row needs an augmenting path through
  // all rows.
  Problem problem{kRows, kRows, {}, 1e6};
  for (std::size_t row = 0; row + 1 < kRows; ++row) {
    problem.pairs.push_back({row, row, 0.0});
    problem.pairs.push_back({row, row + 1, 1.0});
  }
  problem.pairs.push_back({kRows - 1, 0, 0.0});
  const Columns columns = Solve(problem);
  for (std::size_t row = 0; row < kRows; ++row) ASSERT_EQ(columns[row], (row + 1) % kRows);
}

/// Returns the problem without the pair of a row and a column.
Problem Without(std::size_t row, std::size_t column, Problem problem) {
  std::erase_if(problem.pairs, [&](const AssignmentPair& pair) {
    return pair.row == row && pair.column == column;
  });
  return problem;
}

Columns SolveClearly(const Problem& problem, double margin) {
  return AssignClearColumns(
      problem.row_count, problem.column_count, problem.pairs, problem.unmatched_cost, margin);
}

TEST(AssignClearColumns, KeepsThePairsThatNoOtherMatchingCanDoWithout) {
  constexpr double kMargin = 0.5;
  std::mt19937 random(4);
  for (int round = 0; round < 1000; ++round) {
    const Problem problem = RandomProblem(4, /*with_ties=*/false, &random);
    const Columns columns = Solve(problem);
    Columns expected(problem.row_count);
    for (std::size_t row = 0; row < problem.row_count; ++row) {
      if (!columns[row]) continue;
      const double loss = LeastCost(Without(row, *columns[row], problem)) - LeastCost(problem);
      if (loss > kMargin) expected[row] = columns[row];
    }
    ASSERT_EQ(SolveClearly(problem, kMargin), expected) << "round " << round;
  }
}

TEST(AssignClearColumns, TwoRowsThatNeedEachOthersSecondChoiceAreClear) {
  const Problem problem{2, 2, {{0, 0, -0.9}, {0, 1, -0.85}, {1, 0, -0.85}, {1, 1, -0.9}}, 0.0};
  EXPECT_EQ(SolveClearly(problem, 0.08), (Columns{0, 1}));
  EXPECT_EQ(SolveClearly(problem, 0.12), Columns(2));
}

TEST(AssignClearColumns, OfEqualColumnsNoneIsChosen) {
  const Problem problem{1, 2, {{0, 0, -0.9}, {0, 1, -0.9}}, 0.0};
  EXPECT_EQ(Solve(problem), Columns{0});
  EXPECT_EQ(SolveClearly(problem, 0.0), Columns(1));
}

}  // namespace
}  // namespace steadymap
