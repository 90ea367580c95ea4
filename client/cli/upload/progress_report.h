#pragma once

#include <cstddef>
#include <functional>
#include <mutex>
#include <ostream>
#include <set>
#include <string>

#include "client/upload/upload_progress.h"

namespace steadymap {

/// A clock that never goes back, seconds since some moment.
double SteadySeconds();

/// Shows how far a job of many frames has come: a bar that is drawn over itself on a terminal, a
/// line every tenth of the way elsewhere. Thread-safe.
class ProgressReport {
 public:
  /// `verb` says what happens to the frames, such as `integrated`. `now_s` is a clock, seconds.
  ProgressReport(std::ostream* out,
                 bool is_terminal,
                 std::string verb,
                 std::size_t frame_total,
                 std::function<double()> now_s);

  /// Notes that `done` frames have come the whole way, `refused` others never will, and `ahead`,
  /// these two included, are half of the way or further.
  void Update(std::size_t done, std::size_t ahead, std::size_t refused = 0);

  /// Names a reason that frames are refused for; once is enough.
  void NameRefusal(const std::string& reason);

  /// Writes a line of its own, above the bar.
  void Note(const std::string& line);

  /// Leaves the bar behind.
  void End();

 private:
  std::string Line(double elapsed_s) const;
  void Draw(double elapsed_s);
  void Clear();

  std::ostream* out_;
  bool is_terminal_;
  std::string verb_;
  std::size_t frame_total_;
  std::function<double()> now_s_;
  double start_s_;

  std::mutex mutex_;  ///< Guards what follows and `out_`.
  std::size_t done_ = 0;
  std::size_t ahead_ = 0;
  std::size_t refused_ = 0;
  std::set<std::string> refusals_;  ///< Few: the service has some dozen reasons.
  std::size_t tenths_shown_ = 0;
  double last_drawn_s_ = 0.0;
  bool is_drawn_ = false;
};

}  // namespace steadymap
