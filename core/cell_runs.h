#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/semantic_cloud.h"

namespace steadymap {

/// Neighbouring cells of one row that have weight and the same owner: columns [begin, end).
struct CellRun {
  int row = 0;
  int begin = 0;
  int end = 0;
};

/// The cells of a frame by owner, so that each owner costs what it shows, however many there are.
/// Keeps its memory from frame to frame. One thread at a time.
class CellRuns {
 public:
  /// Takes the cells as they are. Cost: one pass over them.
  void Compute(const SemanticCloud& cloud);

  /// Those of one owner, by row and column. Valid until the next `Compute`.
  std::span<const CellRun> Of(std::uint32_t owner) const;

 private:
  struct OwnedRun {
    std::uint32_t owner = 0;
    CellRun run;
  };

  std::vector<OwnedRun> found_;
  std::vector<CellRun> runs_;       ///< By owner.
  std::vector<std::size_t> first_;  ///< By owner, where its runs begin; one more at the end.
};

}  // namespace steadymap
