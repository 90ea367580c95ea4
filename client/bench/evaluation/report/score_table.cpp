#include "client/bench/evaluation/report/score_table.h"

#include <cmath>

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include "client/bench/evaluation/report/reported_scores.h"

namespace steadymap {
namespace {

// clang-format off
constexpr char kMapHeading[] =
    "                     | voxel               | near                |ghosts   kept  kept/  trail |   MB  kB/ delta kB   ms/\n"
    "map                  | prec. recall    FPR | prec. recall    FPR |              static        |       obj   /frame frame\n";
constexpr char kEventHeading[] =
    "                     | created, lenient    | removed, lenient    | moved, lenient      | all, one to one     |frames  false  Brier\n"
    "events               | prec. recall     F1 | prec. recall     F1 | prec. recall     F1 | prec. recall     F1 | until /1000f  score\n";

// clang-format on

std::string Percent(double share, int decimals) {
  if (!std::isfinite(share)) return "-";
  return absl::StrFormat("%.*f", decimals, 100.0 * share);
}

std::string Decimal(double value, int decimals) {
  return std::isfinite(value) ? absl::StrFormat("%.*f", decimals, value) : "-";
}

std::string SurfaceCells(const SurfaceScore& score) {
  return absl::StrFormat("%6s %6s %6s",
                         Percent(score.precision(), 1),
                         Percent(score.recall(), 1),
                         Percent(score.false_positive_rate(), 2));
}

const MethodScore* FindRow(const Evaluation& evaluation, std::string_view name) {
  for (const MethodScore& row : evaluation.rows) {
    if (row.name == name) return &row;
  }
  return nullptr;
}

// Returns the `kept` score relative to that of `static`, which never removes surface.
double KeptOfStatic(const MethodScore& row, const Evaluation& evaluation) {
  const MethodScore* yardstick = FindRow(evaluation, "static");
  if (yardstick == nullptr) return std::nan("");
  return row.map.kept.value() / yardstick->map.kept.value();
}

std::string MethodLine(const MethodScore& row, const Evaluation& evaluation) {
  return absl::StrFormat("%-21s|%s |%s |%6s %6s %6s %6s |%5.1f %4s %8s %5s\n",
                         row.name,
                         SurfaceCells(row.map.voxel),
                         SurfaceCells(row.map.near),
                         Percent(row.map.ghosts.value(), 1),
                         Percent(row.map.kept.value(), 1),
                         Percent(KeptOfStatic(row, evaluation), 1),
                         Percent(row.map.trail.value(), 1),
                         static_cast<double>(row.cost.memory_bytes) / 1e6,
                         Decimal(row.cost.bytes_per_object / 1e3, 0),
                         Decimal(row.cost.delta_bytes_per_frame / 1e3, 1),
                         Decimal(row.cost.median_frame_ms, 1));
}

std::string DetectionCells(const DetectionScore& score) {
  return absl::StrFormat("%6s %6s %6s",
                         Percent(score.precision(), 1),
                         Percent(score.recall(), 1),
                         Percent(score.f1(), 1));
}

std::string EventLine(const MethodScore& row) {
  const EventScore& events = row.events;
  return absl::StrFormat("%-21s|%s |%s |%s |%s |%6s %6s %6s\n",
                         row.name,
                         DetectionCells(events.lenient.created),
                         DetectionCells(events.lenient.removed),
                         DetectionCells(events.lenient.moved),
                         DetectionCells(events.one_to_one.all()),
                         Decimal(events.median_latency_frames(), 0),
                         Decimal(events.false_removals_per_1000_frames(), 1),
                         Decimal(row.brier, 3));
}

std::string EventTable(const Evaluation& evaluation) {
  std::string text = kEventHeading;
  for (const MethodScore& row : evaluation.rows) {
    if (!row.last_sequence_only) text += EventLine(row);
  }
  return text;
}

/// Returns the errors of the poses as a line of text; empty if no method registers frames.
std::string PoseLine(const Evaluation& evaluation) {
  std::string registered;
  for (const MethodScore& row : evaluation.rows) {
    if (row.registered_poses.points == 0) continue;
    absl::StrAppend(
        &registered, ", ", row.name, " registered ", MillimetreText(row.registered_poses));
    if (row.registered_poses.stated_poses == 0) continue;
    absl::StrAppend(&registered, " (", SigmaText(row.registered_poses), " sigmas)");
  }
  if (registered.empty() || evaluation.claimed_poses.points == 0) return {};
  return absl::StrCat("poses                | RMS error, mm: claimed ",
                      MillimetreText(evaluation.claimed_poses),
                      registered,
                      "\n");
}

std::string Heading(const Evaluation& evaluation) {
  const MapScore& map = evaluation.rows.front().map;
  const std::string skipped = evaluation.skipped_count > 0
                                  ? absl::StrFormat(" (%d more unusable)", evaluation.skipped_count)
                                  : std::string();
  return absl::StrFormat(
      "%s: %d frames%s, %d %s, voxels of %g cm, %d of them scored: %d true, %d vanished, "
      "%d remembered\n",
      evaluation.title,
      evaluation.frame_count,
      skipped,
      evaluation.seed_count,
      evaluation.seed_count == 1 ? "seed" : "seeds",
      100.0 * evaluation.voxel_size_m,
      evaluation.scored_voxels,
      (map.near.recalled + map.near.missed) / evaluation.seed_count,
      map.ghosts.whole / evaluation.seed_count,
      map.kept.whole / evaluation.seed_count);
}

}  // namespace

std::string ScoreTable(const Evaluation& evaluation) {
  std::string text = Heading(evaluation);
  text += kMapHeading;
  for (const MethodScore& row : evaluation.rows) {
    absl::StrAppend(&text, MethodLine(row, evaluation));
  }
  for (const ReportedScore& row : ReportedScoresFor(evaluation.title)) {
    absl::StrAppendFormat(&text,
                          "%-21s|%6.1f %6.1f %6.1f | as its authors reported\n",
                          std::string(row.method),
                          row.precision_percent,
                          row.recall_percent,
                          row.false_positive_percent);
  }
  if (evaluation.has_history) text += EventTable(evaluation);
  return text + PoseLine(evaluation);
}

std::string EventFaultText(const Evaluation& evaluation) {
  std::string text;
  for (const MethodScore& row : evaluation.rows) {
    if (row.last_sequence_only) continue;
    absl::StrAppend(&text, row.name, ", faults in the events: ", row.event_faults.size(), "\n");
    for (const std::string& fault : row.event_faults) absl::StrAppend(&text, "  ", fault, "\n");
  }
  return text;
}

}  // namespace steadymap
