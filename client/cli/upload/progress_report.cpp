#include "client/cli/upload/progress_report.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include <absl/strings/str_join.h>

#include "client/cli/text/number_text.h"

namespace steadymap {
namespace {

constexpr std::size_t kBarWidth = 30;

// A shorter period would only load the terminal.
constexpr double kRedrawPeriodS = 0.1;

constexpr char kEraseLine[] = "\r\x1b[K";

std::string RateText(std::size_t count, const std::string& items, double elapsed_s) {
  if (elapsed_s <= 0.0) return "-";
  return FixedText(static_cast<double>(count) / elapsed_s, 1) + " " + items + "/s";
}

}  // namespace

double SteadySeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

ProgressReport::ProgressReport(std::ostream* out,
                               bool is_terminal,
                               std::string verb,
                               std::size_t total,
                               std::function<double()> now_s,
                               std::string items)
    : out_(out),
      is_terminal_(is_terminal),
      verb_(std::move(verb)),
      items_(std::move(items)),
      total_(std::max<std::size_t>(total, 1)),
      now_s_(std::move(now_s)),
      start_s_(now_s_()) {}

void ProgressReport::Update(std::size_t done, std::size_t ahead, std::size_t refused) {
  const std::lock_guard<std::mutex> lock(mutex_);
  done_ = std::min(done, total_);
  refused_ = std::min(refused, total_ - done_);
  const std::size_t settled = done_ + refused_;
  ahead_ = std::min(std::max(ahead, settled), total_);
  const double elapsed_s = now_s_() - start_s_;
  if (is_terminal_) {
    if (is_drawn_ && settled < total_ && elapsed_s - last_drawn_s_ < kRedrawPeriodS) return;
    last_drawn_s_ = elapsed_s;
    Draw(elapsed_s);
    return;
  }
  const std::size_t tenths = 10 * settled / total_;
  if (tenths <= tenths_shown_) return;
  tenths_shown_ = tenths;
  *out_ << Line(elapsed_s) << std::endl;
}

void ProgressReport::AddRefusalReason(const std::string& reason) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!reason.empty()) refusals_.insert(reason);
}

void ProgressReport::Note(const std::string& line) {
  const std::lock_guard<std::mutex> lock(mutex_);
  Clear();
  *out_ << line << std::endl;
}

void ProgressReport::End() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (is_drawn_) *out_ << std::endl;
  is_drawn_ = false;
}

std::string ProgressReport::Line(double elapsed_s) const {
  std::string line =
      std::to_string(done_) + "/" + std::to_string(total_) + " " + items_ + " " + verb_;
  if (refused_ > 0) {
    line += ", " + std::to_string(refused_) + " refused";
    if (!refusals_.empty()) line += " (" + absl::StrJoin(refusals_, ", ") + ")";
  }
  return line + ", " + RateText(done_, items_, elapsed_s);
}

void ProgressReport::Draw(double elapsed_s) {
  const std::size_t full = kBarWidth * (done_ + refused_) / total_;
  const std::size_t half = kBarWidth * ahead_ / total_ - full;
  *out_ << kEraseLine << '[' << std::string(full, '#') << std::string(half, '-')
        << std::string(kBarWidth - full - half, ' ') << "] " << Line(elapsed_s) << std::flush;
  is_drawn_ = true;
}

void ProgressReport::Clear() {
  if (is_drawn_) *out_ << kEraseLine;
  is_drawn_ = false;
}

}  // namespace steadymap
