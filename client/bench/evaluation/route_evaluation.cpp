#include "client/bench/evaluation/route_evaluation.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "client/bench/evaluation/method/method_run.h"
#include "client/bench/evaluation/score/belief_score.h"
#include "client/bench/evaluation/score/event_faults.h"
#include "client/bench/evaluation/score/pose_score.h"
#include "client/bench/evaluation/score/route_reference.h"

namespace steadymap {
namespace {

constexpr std::string_view kTableTop = "table-top";

// Plays all frames and records their claimed poses; errors occur only before the first frame.
absl::StatusOr<std::vector<MethodOutcome>> PlayFrames(const RouteEvaluationOptions& options,
                                                      Simulation* simulation,
                                                      CameraPath* claimed) {
  std::vector<MethodRun> runs;
  for (const Method& method : options.methods) {
    absl::StatusOr<MethodRun> run = MethodRun::Start(method);
    if (!run.ok()) return run.status();
    runs.push_back(*std::move(run));
  }
  const std::size_t last_sequence = simulation->route().sequences.size() - 1;
  for (std::size_t i = 0; i < simulation->frame_count(); ++i) {
    const Frame frame = simulation->Render(i);
    claimed->push_back({frame.capture_time, frame.T_world_camera});
    const bool is_last_sequence = simulation->SequenceOf(i) == last_sequence;
    const bool ends_sequence = i + 1 == simulation->frame_count() ||
                               simulation->SequenceOf(i + 1) != simulation->SequenceOf(i);
    for (MethodRun& run : runs) {
      run.Integrate(frame, is_last_sequence);
      if (ends_sequence) run.EndSequence();
    }
    if (options.on_frame) options.on_frame();
  }
  std::vector<MethodOutcome> outcomes;
  outcomes.reserve(runs.size());
  for (MethodRun& run : runs) {
    outcomes.push_back(run.Finish(SampleSpacingFor(options.voxel_size_m)));
  }
  return outcomes;
}

CameraPath TruePath(const Simulation& simulation) {
  CameraPath path;
  path.reserve(simulation.frame_count());
  for (std::size_t i = 0; i < simulation.frame_count(); ++i) {
    path.push_back({simulation.CaptureTimeOf(i), simulation.TruePose(i)});
  }
  return path;
}

SurveyOptions SurveyOptionsFor(const RouteEvaluationOptions& options) {
  SurveyOptions survey;
  survey.voxel_size_m = options.voxel_size_m;
  survey.spacing_m = SampleSpacingFor(options.voxel_size_m);
  survey.max_depth_m = options.methods.front().config.max_depth_m;
  return survey;
}

// The other policies keep no beliefs.
bool HasBeliefs(const Method& method) {
  return method.config.policy == UpdatePolicy::kPocd ||
         method.config.policy == UpdatePolicy::kPocdPaper;
}

// Adds the map's beliefs about all objects that were confirmed.
void AddBeliefs(const MapSnapshot& map,
                const MapScorer& scorer,
                double spacing_m,
                std::vector<BeliefSample>* beliefs) {
  for (const auto& [id, object] : map.objects) {
    if (object->status == ObjectStatus::kTentative) continue;
    const std::vector<SurfacePoint> surface = SampleObject(*object, map.scale, spacing_m);
    if (surface.empty()) continue;
    beliefs->push_back({object->belief.stationarity(), scorer.IsStillTrue(surface)});
  }
}

}  // namespace

absl::StatusOr<Evaluation> EvaluateRoute(const Route& route,
                                         const RouteEvaluationOptions& options) {
  assert(!options.methods.empty() && !options.seeds.empty());
  Evaluation evaluation;
  evaluation.title = route.name;
  evaluation.voxel_size_m = options.voxel_size_m;
  evaluation.seed_count = options.seeds.size();
  evaluation.has_history = route.sequences.size() > 1;
  for (const Method& method : options.methods) {
    MethodScore& row = evaluation.rows.emplace_back();
    row.name = method.name;
    row.last_sequence_only = method.last_sequence_only;
  }

  const Simulation first(route, options.simulation);
  evaluation.frame_count = first.frame_count();
  RouteSurvey survey = SurveyRoute(first, SurveyOptionsFor(options));
  EventTruth event_truth = ListTrueEvents(route, survey);
  Reference reference = MakeReference(&survey, options.with_ground);
  if (options.visit_reference) options.visit_reference(reference);
  const MapScorer scorer(std::move(reference));
  evaluation.scored_voxels = scorer.scored_voxels();

  std::vector<std::vector<BeliefSample>> beliefs(options.methods.size());
  for (std::size_t seed = 0; seed < options.seeds.size(); ++seed) {
    SimulationOptions noise = options.simulation;
    noise.seed = options.seeds[seed];
    Simulation simulation(route, noise);
    CameraPath claimed;
    const absl::StatusOr<std::vector<MethodOutcome>> outcomes =
        PlayFrames(options, &simulation, &claimed);
    if (!outcomes.ok()) return outcomes.status();
    event_truth.capture_times.clear();
    for (const StampedPose& pose : claimed) event_truth.capture_times.push_back(pose.time);
    const CameraPath truth = TruePath(simulation);
    evaluation.claimed_poses += ScorePoses(truth, claimed);
    for (std::size_t i = 0; i < outcomes->size(); ++i) {
      const MethodOutcome& outcome = (*outcomes)[i];
      MethodScore& row = evaluation.rows[i];
      row.map += scorer.Score(outcome.surface);
      row.events += ScoreEvents(event_truth, outcome.events);
      row.event_faults = ListEventFaults(event_truth, outcome.events);
      row.registered_poses += ScorePoses(truth, outcome.registered);
      row.cost = outcome.cost;
      if (HasBeliefs(options.methods[i])) {
        AddBeliefs(*outcome.map, scorer, SampleSpacingFor(options.voxel_size_m), &beliefs[i]);
      }
      if (seed == 0 && options.visit_map) options.visit_map(row.name, scorer, outcome);
    }
  }
  for (std::size_t i = 0; i < beliefs.size(); ++i) {
    evaluation.rows[i].brier = BrierScore(beliefs[i]);
  }
  return evaluation;
}

MapConfig MapConfigFor(std::string_view route) {
  MapConfig config;
  if (route != kTableTop) return config;
  config.voxel_size_m = 0.02;
  config.truncation_m = 0.06;
  config.max_depth_m = 4.0;
  return config;
}

double EvaluationVoxelFor(std::string_view route) { return route == kTableTop ? 0.06 : 0.2; }

double SampleSpacingFor(double voxel_size_m) { return std::min(0.025, 0.25 * voxel_size_m); }

}  // namespace steadymap
