#pragma once

#include <cstddef>
#include <functional>
#include <mutex>
#include <ostream>
#include <set>
#include <string>

#include "client/upload/upload_progress.h"

namespace steadymap {

/// Returns the time of a monotonic clock in seconds, since an arbitrary origin.
double SteadySeconds();

/// Shows the progress of a job of many items, such as frames: a bar that is redrawn in place on a
/// terminal, otherwise one line for every tenth of the items. Thread-safe.
class ProgressReport {
 public:
  /// `verb` describes the processing of the items, such as `integrated`. `now_s` returns the time
  /// in seconds. `items`: their name in the plural.
  ProgressReport(std::ostream* out,
                 bool is_terminal,
                 std::string verb,
                 std::size_t total,
                 std::function<double()> now_s,
                 std::string items = "frames");

  /// Records the progress: `done` items are complete, `refused` items will never be, and `ahead`
  /// items, including both, have completed at least the first half of the processing.
  void Update(std::size_t done, std::size_t ahead, std::size_t refused = 0);

  /// Adds a reason for refused items. Repeated calls with the same reason have no effect.
  void AddRefusalReason(const std::string& reason);

  /// Writes a separate line above the bar.
  void Note(const std::string& line);

  /// Ends the report and leaves the bar on the terminal.
  void End();

 private:
  std::string Line(double elapsed_s) const;
  void Draw(double elapsed_s);
  void Clear();

  std::ostream* out_;
  bool is_terminal_;
  std::string verb_;
  std::string items_;
  std::size_t total_;
  std::function<double()> now_s_;
  double start_s_;

  std::mutex mutex_;  ///< Guards `out_` and the members below.
  std::size_t done_ = 0;
  std::size_t ahead_ = 0;
  std::size_t refused_ = 0;
  std::set<std::string> refusals_;  ///< Bounded: the service has about a dozen reasons.
  std::size_t tenths_shown_ = 0;
  double last_drawn_s_ = 0.0;
  bool is_drawn_ = false;
};

}  // namespace steadymap
