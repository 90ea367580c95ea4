#include "client/bench/evaluation/fleet/fleet_evaluation.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include <absl/strings/str_format.h>

#include "client/bench/evaluation/route_evaluation.h"
#include "client/bench/evaluation/score/route_reference.h"
#include "client/bench/evaluation/truth/event_truth.h"
#include "client/bench/evaluation/truth/route_survey.h"
#include "client/bench/evaluation/truth/surface_points.h"
#include "client/bench/simulator/simulation.h"
#include "core/mapper.h"
#include "core/types/absl_text.h"

namespace steadymap {
namespace {

constexpr std::size_t kFramesPerFleetCommit = 15;

SensorName SecondRobot() { return {"second", SensorName::kDefaultSensor}; }

/// Returns the route as a robot sees it for which nothing has changed since the first sequence.
Route OutdatedRoute(Route route) {
  for (RouteSequence& sequence : route.sequences) sequence.scene = route.sequences.front().scene;
  return route;
}

/// Plays one case into a map.
class FleetRun {
 public:
  FleetRun(const FleetCase& fleet_case,
           const Route& route,
           const FleetEvaluationOptions& options,
           std::unique_ptr<Mapper> mapper)
      : case_(fleet_case),
        simulation_(RouteOf(fleet_case, route), SimulationOf(options)),
        outdated_(OutdatedRoute(RouteOf(fleet_case, route)), SimulationOf(options)),
        mapper_(std::move(mapper)) {}

  Simulation& simulation() { return simulation_; }

  const std::vector<ObjectEvent>& events() const { return events_; }

  /// Returns the final map.
  std::shared_ptr<const MapSnapshot> Play() {
    std::vector<std::size_t> frames(simulation_.frame_count());
    for (std::size_t i = 0; i < frames.size(); ++i) frames[i] = i;
    if (case_.is_newest_first) {
      std::stable_sort(frames.begin(), frames.end(), [this](std::size_t a, std::size_t b) {
        return simulation_.SequenceOf(a) > simulation_.SequenceOf(b);
      });
    }
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const bool is_last = i + 1 == frames.size();
      Play(frames[i]);
      if (is_last || EndsUpload(frames[i], frames[i + 1])) EndSessions();
      if (is_last || mapper_->uncommitted_entries() >= kFramesPerFleetCommit) Commit();
    }
    return map_;
  }

 private:
  static SimulationOptions SimulationOf(const FleetEvaluationOptions& options) {
    SimulationOptions simulation;
    simulation.sensor = options.sensor;
    simulation.seed = options.seed;
    return simulation;
  }

  Duration Ahead() const { return Duration::FromSeconds(case_.second_ahead_s); }

  bool IsOfSecond(std::size_t frame) const {
    const std::size_t last = simulation_.route().sequences.size() - 1;
    return (case_.has_second_robot && frame % 2 == 1) ||
           (case_.has_past_of_second && simulation_.SequenceOf(frame) < last);
  }

  /// True if a frame shows the world as it was in the first sequence.
  bool IsOutdated(std::size_t frame) const {
    const auto drives = static_cast<std::size_t>(case_.contradicting_drives);
    return !IsOfSecond(frame) &&
           simulation_.SequenceOf(frame) + drives >= simulation_.route().sequences.size();
  }

  bool EndsUpload(std::size_t frame, std::size_t next) const {
    return !case_.is_one_upload && simulation_.SequenceOf(next) != simulation_.SequenceOf(frame);
  }

  void Play(std::size_t index) {
    const bool is_of_second = IsOfSecond(index);
    Frame frame = (IsOutdated(index) ? outdated_ : simulation_).Render(index);
    if (is_of_second) {
      frame.source = SecondRobot();
      frame.capture_time = frame.capture_time + Ahead();
      frame.T_world_camera.translation().x() += case_.second_offset_m;
    }
    mapper_->Integrate(mapper_->head().Next(), frame);
    if (std::find(sources_.begin(), sources_.end(), frame.source) == sources_.end()) {
      sources_.push_back(frame.source);
    }
    last_time_ = simulation_.CaptureTimeOf(index);
  }

  void EndSessions() {
    for (const SensorName& source : sources_) {
      mapper_->EndSession(mapper_->head().Next(), source);
    }
  }

  void Commit() {
    MapCommit commit = mapper_->Commit();
    for (ObjectEvent& event : commit.delta.events) {
      // By the wrong clock of the second robot.
      if (event.time > last_time_) event.time = event.time - Ahead();
      events_.push_back(std::move(event));
    }
    map_ = std::move(commit.snapshot);
  }

  FleetCase case_;
  Simulation simulation_;
  Simulation outdated_;  ///< As the first robot sees it in contradicting drives.
  std::unique_ptr<Mapper> mapper_;
  std::vector<SensorName> sources_;
  Timestamp last_time_;  ///< True capture time of the last frame.
  std::vector<ObjectEvent> events_;
  std::shared_ptr<const MapSnapshot> map_;
};

absl::StatusOr<FleetResult> EvaluateCase(const FleetCase& fleet_case,
                                         const Route& route,
                                         const FleetEvaluationOptions& options) {
  absl::StatusOr<std::unique_ptr<Mapper>> mapper = Mapper::Create(options.config);
  if (!mapper.ok()) return mapper.status();
  FleetRun run(fleet_case, route, options, *std::move(mapper));
  const std::shared_ptr<const MapSnapshot> map = run.Play();

  Simulation& simulation = run.simulation();
  SurveyOptions survey_options;
  survey_options.voxel_size_m = options.voxel_size_m;
  survey_options.spacing_m = SampleSpacingFor(options.voxel_size_m);
  survey_options.max_depth_m = options.config.max_depth_m;
  RouteSurvey survey = SurveyRoute(simulation, survey_options);
  EventTruth truth = ListTrueEvents(simulation.route(), survey);
  for (std::size_t i = 0; i < simulation.frame_count(); ++i) {
    truth.capture_times.push_back(simulation.CaptureTimeOf(i));
  }
  const MapScorer scorer(MakeReference(&survey, /*with_ground=*/false));

  FleetResult result;
  result.fleet_case = fleet_case;
  result.frame_count = simulation.frame_count();
  result.map = scorer.Score(SampleMap(*map, survey_options.spacing_m));
  result.events = ScoreEvents(truth, run.events());
  for (const ObjectEvent& event : run.events()) ++result.event_counts[event.type];
  result.archived_count = static_cast<std::size_t>(
      std::count_if(map->objects.begin(), map->objects.end(), [](const auto& entry) {
        return entry.second->status == ObjectStatus::kArchived;
      }));
  return result;
}

std::size_t CountOf(const FleetResult& result, EventType type) {
  const auto found = result.event_counts.find(type);
  return found == result.event_counts.end() ? 0 : found->second;
}

std::string PercentText(double share) {
  return std::isnan(share) ? "-" : absl::StrFormat("%.1f", 100.0 * share);
}

}  // namespace

absl::StatusOr<std::vector<FleetResult>> EvaluateFleet(const Route& route,
                                                       const FleetEvaluationOptions& options) {
  std::vector<FleetResult> results;
  for (const FleetCase& fleet_case : options.cases) {
    absl::StatusOr<FleetResult> result = EvaluateCase(fleet_case, route, options);
    if (!result.ok()) return result.status();
    results.push_back(*std::move(result));
    if (options.on_case) options.on_case();
  }
  return results;
}

std::string FleetTable(const std::vector<FleetResult>& results) {
  std::string text =
      absl::StrFormat("%-14s | %6s | %9s | %6s | %6s | %6s | %8s | %7s | %5s | %12s | %4s | %8s\n",
                      "%",
                      "frames",
                      "precision",
                      "recall",
                      "ghosts",
                      "F1",
                      "created",
                      "removed",
                      "moved",
                      "contradicted",
                      "lost",
                      "archived");
  for (const FleetResult& result : results) {
    text += absl::StrFormat(
        "%-14s | %6d | %9s | %6s | %6s | %6s | %8d | %7d | %5d | %12d | %4d | %8d\n",
        Absl(result.fleet_case.name),
        result.frame_count,
        PercentText(result.map.near.precision()),
        PercentText(result.map.near.recall()),
        PercentText(result.map.ghosts.value()),
        PercentText(result.events.one_to_one.all().f1()),
        CountOf(result, EventType::kCreated),
        CountOf(result, EventType::kRemoved),
        CountOf(result, EventType::kMoved),
        CountOf(result, EventType::kContradicted),
        CountOf(result, EventType::kRobotLost),
        result.archived_count);
  }
  return text;
}

}  // namespace steadymap
