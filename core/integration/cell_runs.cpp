#include "core/integration/cell_runs.h"

#include <algorithm>
#include <numeric>

namespace steadymap {

void CellRuns::Compute(const SemanticCloud& cloud) {
  found_.clear();
  std::size_t owners = 0;
  for (int row = 0; row < cloud.cells_high(); ++row) {
    int column = 0;
    while (column < cloud.cells_wide()) {
      const SurfaceCell& first = cloud.At(column, row);
      if (!(first.weight > 0.0F)) {
        ++column;
        continue;
      }
      const std::uint32_t owner = first.owner;
      const int begin = column;
      do {
        ++column;
      } while (column < cloud.cells_wide() && cloud.At(column, row).weight > 0.0F &&
               cloud.At(column, row).owner == owner);
      found_.push_back({owner, {row, begin, column}});
      owners = std::max(owners, std::size_t{owner} + 1);
    }
  }
  // A counting sort: the runs of an owner stay in the order of rows.
  first_.assign(owners + 1, 0);
  for (const OwnedRun& found : found_) ++first_[std::size_t{found.owner} + 1];
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  std::vector<std::size_t> next(first_.begin(), first_.end());
  runs_.resize(found_.size());
  for (const OwnedRun& found : found_) runs_[next[found.owner]++] = found.run;
}

std::span<const CellRun> CellRuns::Of(std::uint32_t owner) const {
  if (std::size_t{owner} + 1 >= first_.size()) return {};
  return std::span(runs_).subspan(first_[owner], first_[std::size_t{owner} + 1] - first_[owner]);
}

}  // namespace steadymap
