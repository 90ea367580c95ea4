#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/integration/semantic_cloud.h"

namespace steadymap {

/// Adjacent cells of one row, columns [begin, end), that have weight and the same owner.
struct CellRun {
  int row = 0;
  int begin = 0;
  int end = 0;
};

/// Indexes the cells of a frame by owner, so that work on one owner costs its own cells and not the
/// whole image. Keeps its memory from frame to frame. One thread at a time.
class CellRuns {
 public:
  /// Indexes the cells of `cloud`. Cost: one pass over them.
  void Compute(const SemanticCloud& cloud);

  /// The runs of one owner, by row and column. Valid until the next `Compute`.
  std::span<const CellRun> Of(std::uint32_t owner) const;

 private:
  struct OwnedRun {
    std::uint32_t owner = 0;
    CellRun run;
  };

  std::vector<OwnedRun> found_;
  std::vector<CellRun> runs_;       ///< By owner.
  std::vector<std::size_t> first_;  ///< By owner, the index of its first run; one more at the end.
};

}  // namespace steadymap
