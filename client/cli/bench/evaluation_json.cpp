#include "client/cli/bench/evaluation_json.h"

#include <algorithm>
#include <string>
#include <utility>

#include "client/bench/evaluation/report/reported_scores.h"

namespace steadymap {
namespace {

Json SurfaceJson(const SurfaceScore& score) {
  return {{"precision", score.precision()},
          {"recall", score.recall()},
          {"false_positive_rate", score.false_positive_rate()},
          {"matched_voxels", score.true_positives},
          {"wrong_voxels", score.false_positives},
          {"found_voxels", score.recalled},
          {"missed_voxels", score.missed},
          {"empty_voxels", score.true_negatives}};
}

Json ShareJson(const Share& share) {
  return {{"share", share.value()}, {"part", share.part}, {"whole", share.whole}};
}

Json DetectionJson(const DetectionScore& score) {
  return {{"precision", score.precision()},
          {"recall", score.recall()},
          {"f1", score.f1()},
          {"claimed", score.right.whole},
          {"right", score.right.part},
          {"true", score.found.whole},
          {"found", score.found.part}};
}

Json DetectionsJson(const DetectionScores& scores) {
  return {{"created", DetectionJson(scores.created)},
          {"removed", DetectionJson(scores.removed)},
          {"moved", DetectionJson(scores.moved)},
          {"all", DetectionJson(scores.all())}};
}

Json EventsJson(const EventScore& score) {
  return {{"lenient", DetectionsJson(score.lenient)},
          {"one_to_one", DetectionsJson(score.one_to_one)},
          {"median_latency_frames", score.median_latency_frames()},
          {"max_latency_frames", score.max_latency_frames()},
          {"false_removals", score.false_removals},
          {"false_removals_per_1000_frames", score.false_removals_per_1000_frames()}};
}

// Returns times by stage name, with words joined by underscores.
Json StagesJson(const StageTimes& stage_ms) {
  Json json = Json::object();
  for (std::size_t stage = 0; stage < stage_ms.size(); ++stage) {
    std::string name(kMapperStageNames[stage]);
    std::replace(name.begin(), name.end(), ' ', '_');
    json[name] = stage_ms[stage];
  }
  return json;
}

Json RowJson(const MethodScore& row, bool has_history) {
  Json json = {{"policy", row.name},
               {"voxel", SurfaceJson(row.map.voxel)},
               {"near", SurfaceJson(row.map.near)}};
  if (has_history) {
    json["ghosts"] = ShareJson(row.map.ghosts);
    json["kept"] = ShareJson(row.map.kept);
    if (!row.last_sequence_only) json["events"] = EventsJson(row.events);
  }
  json["trail"] = ShareJson(row.map.trail);
  json["brier"] = row.brier;
  json["registered_poses_rms_m"] = row.registered_poses.rms_m();
  json["registered_poses_rms_sigmas"] = row.registered_poses.rms_sigmas();
  json["memory_bytes"] = row.cost.memory_bytes;
  json["bytes_per_object"] = row.cost.bytes_per_object;
  json["delta_bytes_per_frame"] = row.cost.delta_bytes_per_frame;
  json["median_frame_ms"] = row.cost.median_frame_ms;
  json["stage_ms"] = StagesJson(row.cost.stage_ms);
  return json;
}

Json ReportedJson(const ReportedScore& reported) {
  return {{"method", reported.method},
          {"precision", reported.precision_percent / 100.0},
          {"recall", reported.recall_percent / 100.0},
          {"false_positive_rate", reported.false_positive_percent / 100.0}};
}

Json TableJson(const Evaluation& evaluation) {
  Json rows = Json::array();
  for (const MethodScore& row : evaluation.rows) {
    rows.push_back(RowJson(row, evaluation.has_history));
  }
  Json reported = Json::array();
  for (const ReportedScore& row : ReportedScoresFor(evaluation.title)) {
    reported.push_back(ReportedJson(row));
  }
  return {{"route", evaluation.title},
          {"voxel_size_m", evaluation.voxel_size_m},
          {"frames", evaluation.frame_count},
          {"unusable_frames", evaluation.skipped_count},
          {"seeds", evaluation.seed_count},
          {"scored_voxels", evaluation.scored_voxels},
          {"claimed_poses_rms_m", evaluation.claimed_poses.rms_m()},
          {"rows", std::move(rows)},
          {"reported", std::move(reported)}};
}

}  // namespace

Json EvaluationJson(const std::vector<Evaluation>& evaluations) {
  Json tables = Json::array();
  for (const Evaluation& evaluation : evaluations) tables.push_back(TableJson(evaluation));
  return tables;
}

}  // namespace steadymap
