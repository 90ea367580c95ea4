#include "client/bench/evaluation/report/stage_table.h"

#include <algorithm>
#include <numeric>

#include <absl/strings/str_format.h>

namespace steadymap {
namespace {

constexpr std::size_t kMinStageWidth = 6;

// Shorter times appear as a dash.
constexpr double kShownMs = 0.0005;

}  // namespace

std::string StageTable(const Evaluation& evaluation) {
  std::string text = absl::StrFormat("%-21s|", "ms/frame");
  for (const std::string_view name : kMapperStageNames) {
    const auto width = static_cast<int>(std::max(name.size(), kMinStageWidth));
    text += absl::StrFormat(" %*s", width, std::string(name));
  }
  text += absl::StrFormat(" | %6s\n", "all");
  for (const MethodScore& row : evaluation.rows) {
    text += absl::StrFormat("%-21s|", row.name);
    const StageTimes& times = row.cost.stage_ms;
    for (std::size_t stage = 0; stage < times.size(); ++stage) {
      const auto width =
          static_cast<int>(std::max(kMapperStageNames[stage].size(), kMinStageWidth));
      if (times[stage] < kShownMs) {
        text += absl::StrFormat(" %*s", width, "-");
      } else {
        text += absl::StrFormat(" %*.3f", width, times[stage]);
      }
    }
    text += absl::StrFormat(" | %6.2f\n", std::accumulate(times.begin(), times.end(), 0.0));
  }
  return text;
}

}  // namespace steadymap
