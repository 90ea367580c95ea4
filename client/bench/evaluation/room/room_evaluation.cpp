#include "client/bench/evaluation/room/room_evaluation.h"

#include <map>
#include <string_view>
#include <utility>

#include <absl/strings/str_format.h>

#include "client/bench/evaluation/score/map_score.h"
#include "client/bench/simulator/simulation.h"
#include "core/mapper.h"
#include "core/types/absl_text.h"

namespace steadymap {
namespace {

constexpr std::size_t kFramesPerCommit = 15;

// A robot that rests for so long has ended its session.
constexpr double kSessionPauseS = 10.0;

constexpr double kCuboidToleranceM = 0.03;
constexpr double kEventToleranceM = 0.12;

/// Returns the largest error of the poses of a case, metres.
double PoseErrorM(const RoomCase& room_case) {
  const SensorModel& sensor = room_case.sensor;
  return (sensor.pose_drift ? sensor.pose_drift_m : 0.0) + sensor.session_offset_m;
}

RoomTolerance ToleranceOf(const RoomCase& room_case) {
  return {.place_m = kEventToleranceM + 0.5 * room_case.voxel_size_m + PoseErrorM(room_case),
          .cuboid_m = kCuboidToleranceM + 0.5 * room_case.voxel_size_m + PoseErrorM(room_case),
          .compares_classes = room_case.labels != RoomLabels::kNone};
}

/// True if the robot rests after a frame.
bool EndsSession(const Simulation& simulation, std::size_t frame) {
  if (frame + 1 == simulation.frame_count()) return true;
  const std::size_t next = simulation.SequenceOf(frame + 1);
  return next != simulation.SequenceOf(frame) &&
         simulation.route().sequences[next].pause_s >= kSessionPauseS;
}

absl::StatusOr<RoomResult> EvaluateRoom(const RoomCase& room_case,
                                        const RoomEvaluationOptions& evaluation) {
  MapConfig config = MapConfigFor(room_case, evaluation.policy);
  config.parameters = evaluation.parameters;
  absl::StatusOr<std::unique_ptr<Mapper>> mapper = Mapper::Create(config);
  if (!mapper.ok()) return mapper.status();
  const BoxRoom room = MakeBoxRoom(room_case.change, room_case.setting);
  SimulationOptions options;
  options.sensor = room_case.sensor;
  options.seed = room_case.seed;
  options.include_instances = room_case.labels == RoomLabels::kInstances;
  Simulation simulation(room.route, options);
  std::vector<ObjectEvent> events;
  std::shared_ptr<const MapSnapshot> map;
  const auto commit = [&] {
    MapCommit result = (*mapper)->Commit();
    events.insert(events.end(), result.delta.events.begin(), result.delta.events.end());
    map = std::move(result.snapshot);
  };
  for (std::size_t i = 0; i < simulation.frame_count(); ++i) {
    Frame frame = simulation.Render(i);
    if (room_case.labels == RoomLabels::kNone) frame.labels = {};
    (*mapper)->Integrate((*mapper)->head().Next(), frame);
    if (EndsSession(simulation, i)) (*mapper)->EndSession((*mapper)->head().Next(), frame.source);
    if ((*mapper)->uncommitted_entries() >= kFramesPerCommit) commit();
  }
  commit();
  const RoomTolerance tolerance = ToleranceOf(room_case);
  return RoomResult{room_case, ScoreRoom(room, events, *map, tolerance), tolerance.cuboid_m};
}

/// Counts of the cases of one row.
struct RoomCounts {
  Share labelled;
  Share unlabelled;
  Share cuboids;  ///< Of all exact cases.

  void Add(const RoomResult& result) {
    (result.is_labelled() ? labelled : unlabelled) += {result.score.is_exact() ? 1U : 0U, 1U};
    if (result.score.is_exact()) cuboids += {result.has_right_cuboids() ? 1U : 0U, 1U};
  }
};

std::string RowText(std::string_view name, const RoomCounts& counts) {
  return absl::StrFormat("%-26s | %12s | %12s | %12s\n",
                         Absl(name),
                         CountText(counts.labelled),
                         CountText(counts.unlabelled),
                         CountText(counts.cuboids));
}

std::string FaultText(const RoomResult& result) {
  std::string text = std::string(NameOf(result.room_case.change));
  for (const std::string& variation : result.room_case.variations) text += " " + variation;
  text += result.score.is_exact() ? ": exact" : ":";
  text += absl::StrFormat(", cuboids within %.0f mm\n", 1e3 * result.score.worst_cuboid_m);
  for (const auto* faults :
       {&result.score.event_faults, &result.score.object_faults, &result.score.cuboid_faults}) {
    for (const std::string& fault : *faults) text += "  " + fault + "\n";
  }
  return text;
}

}  // namespace

absl::StatusOr<std::vector<RoomResult>> EvaluateRooms(const RoomEvaluationOptions& options) {
  std::vector<RoomResult> results;
  for (const RoomChange change : options.changes) {
    if (options.labels && !CanBeTold(change, *options.labels)) continue;
    for (RoomCase& room_case : ListRoomCases(change, options.cases, options.seed)) {
      if (options.labels) GiveLabels(*options.labels, &room_case);
      absl::StatusOr<RoomResult> result = EvaluateRoom(room_case, options);
      if (!result.ok()) return result.status();
      results.push_back(*std::move(result));
      if (options.on_case) options.on_case();
    }
  }
  return results;
}

std::string RoomTable(const std::vector<RoomResult>& results, bool with_faults) {
  std::string text;
  std::vector<std::pair<std::string_view, RoomCounts>> by_change;
  std::map<std::string, RoomCounts> by_variation;
  RoomCounts all;
  for (const RoomResult& result : results) {
    if (with_faults) text += FaultText(result);
    const std::string_view name = NameOf(result.room_case.change);
    if (by_change.empty() || by_change.back().first != name) by_change.push_back({name, {}});
    by_change.back().second.Add(result);
    for (const std::string& variation : result.room_case.variations) {
      by_variation[variation].Add(result);
    }
    all.Add(result);
  }
  text +=
      absl::StrFormat("%-26s | %12s | %12s | %12s\n", "exact", "labelled", "unlabelled", "cuboids");
  for (const auto& [name, counts] : by_change) text += RowText(name, counts);
  for (const auto& [name, counts] : by_variation) text += RowText("with " + name, counts);
  return text + RowText("all", all);
}

}  // namespace steadymap
