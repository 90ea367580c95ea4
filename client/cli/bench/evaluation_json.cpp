#include "client/cli/bench/evaluation_json.h"

#include <algorithm>

#include "client/bench/evaluation/report/reported_scores.h"
#include "client/cli/text/json_writer.h"

namespace steadymap {
namespace {

void WriteSurface(std::string_view key, const SurfaceScore& score, JsonWriter* json) {
  json->Key(key).BeginObject();
  json->Key("precision").Number(score.precision());
  json->Key("recall").Number(score.recall());
  json->Key("false_positive_rate").Number(score.false_positive_rate());
  json->Key("matched_voxels").Integer(score.true_positives);
  json->Key("wrong_voxels").Integer(score.false_positives);
  json->Key("found_voxels").Integer(score.recalled);
  json->Key("missed_voxels").Integer(score.missed);
  json->Key("empty_voxels").Integer(score.true_negatives);
  json->EndObject();
}

void WriteShare(std::string_view key, const Share& share, JsonWriter* json) {
  json->Key(key).BeginObject();
  json->Key("share").Number(share.value());
  json->Key("part").Integer(share.part);
  json->Key("whole").Integer(share.whole);
  json->EndObject();
}

void WriteDetection(std::string_view key, const DetectionScore& score, JsonWriter* json) {
  json->Key(key).BeginObject();
  json->Key("precision").Number(score.precision());
  json->Key("recall").Number(score.recall());
  json->Key("f1").Number(score.f1());
  json->Key("claimed").Integer(score.right.whole);
  json->Key("right").Integer(score.right.part);
  json->Key("true").Integer(score.found.whole);
  json->Key("found").Integer(score.found.part);
  json->EndObject();
}

void WriteDetections(std::string_view key, const DetectionScores& scores, JsonWriter* json) {
  json->Key(key).BeginObject();
  WriteDetection("created", scores.created, json);
  WriteDetection("removed", scores.removed, json);
  WriteDetection("moved", scores.moved, json);
  WriteDetection("all", scores.all(), json);
  json->EndObject();
}

void WriteEvents(const EventScore& score, JsonWriter* json) {
  json->Key("events").BeginObject();
  WriteDetections("lenient", score.lenient, json);
  WriteDetections("one_to_one", score.one_to_one, json);
  json->Key("median_latency_frames").Number(score.median_latency_frames());
  json->Key("max_latency_frames").Number(score.max_latency_frames());
  json->Key("false_removals").Integer(score.false_removals);
  json->Key("false_removals_per_1000_frames").Number(score.false_removals_per_1000_frames());
  json->EndObject();
}

// Writes times by stage name, with words joined by underscores.
void WriteStages(const StageTimes& stage_ms, JsonWriter* json) {
  json->Key("stage_ms").BeginObject();
  for (std::size_t stage = 0; stage < stage_ms.size(); ++stage) {
    std::string name(kMapperStageNames[stage]);
    std::replace(name.begin(), name.end(), ' ', '_');
    json->Key(name).Number(stage_ms[stage]);
  }
  json->EndObject();
}

void WriteRow(const MethodScore& row, bool has_history, JsonWriter* json) {
  json->BeginObject();
  json->Key("policy").Text(row.name);
  WriteSurface("voxel", row.map.voxel, json);
  WriteSurface("near", row.map.near, json);
  if (has_history) {
    WriteShare("ghosts", row.map.ghosts, json);
    WriteShare("kept", row.map.kept, json);
    if (!row.last_sequence_only) WriteEvents(row.events, json);
  }
  WriteShare("trail", row.map.trail, json);
  json->Key("brier").Number(row.brier);
  json->Key("memory_bytes").Integer(row.cost.memory_bytes);
  json->Key("bytes_per_object").Number(row.cost.bytes_per_object);
  json->Key("delta_bytes_per_frame").Number(row.cost.delta_bytes_per_frame);
  json->Key("median_frame_ms").Number(row.cost.median_frame_ms);
  WriteStages(row.cost.stage_ms, json);
  json->EndObject();
}

void WriteReported(const ReportedScore& reported, JsonWriter* json) {
  json->BeginObject();
  json->Key("method").Text(reported.method);
  json->Key("precision").Number(reported.precision_percent / 100.0);
  json->Key("recall").Number(reported.recall_percent / 100.0);
  json->Key("false_positive_rate").Number(reported.false_positive_percent / 100.0);
  json->EndObject();
}

void WriteEvaluation(const Evaluation& evaluation, JsonWriter* json) {
  json->BeginObject();
  json->Key("route").Text(evaluation.title);
  json->Key("voxel_size_m").Number(evaluation.voxel_size_m);
  json->Key("frames").Integer(evaluation.frame_count);
  json->Key("unusable_frames").Integer(evaluation.skipped_count);
  json->Key("seeds").Integer(evaluation.seed_count);
  json->Key("scored_voxels").Integer(evaluation.scored_voxels);
  json->Key("rows").BeginArray();
  for (const MethodScore& row : evaluation.rows) WriteRow(row, evaluation.has_history, json);
  json->EndArray();
  json->Key("reported").BeginArray();
  for (const ReportedScore& row : ReportedScoresFor(evaluation.title)) WriteReported(row, json);
  json->EndArray();
  json->EndObject();
}

}  // namespace

std::string EvaluationJson(const std::vector<Evaluation>& evaluations) {
  JsonWriter json;
  json.BeginArray();
  for (const Evaluation& evaluation : evaluations) WriteEvaluation(evaluation, &json);
  json.EndArray();
  return json.Finish();
}

}  // namespace steadymap
