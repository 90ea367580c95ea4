#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/integration/semantic_cloud.h"

namespace steadymap {

/// Adjacent surface cells of one row, columns [begin, end), with non-zero weight and equal owner.
struct CellRun {
  int row = 0;
  int begin = 0;
  int end = 0;
};

/// An index of the surface cells of a frame by owner. The cost of work on one owner is proportional
/// to its own cells, not to the image. Reuses its memory between frames. One thread at a time.
class CellRuns {
 public:
  /// Indexes the cells of `cloud`. Cost: one pass over the cells.
  void Compute(const SemanticCloud& cloud);

  /// Returns the runs of one owner, by row, then column. Valid until the next `Compute`.
  std::span<const CellRun> Of(std::uint32_t owner) const;

 private:
  struct OwnedRun {
    std::uint32_t owner = 0;
    CellRun run;
  };

  std::vector<OwnedRun> found_;
  std::vector<CellRun> runs_;       ///< By owner.
  std::vector<std::size_t> first_;  ///< By owner, the index of its first run; one extra entry.
};

}  // namespace steadymap
