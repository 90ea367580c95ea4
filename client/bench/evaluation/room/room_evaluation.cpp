#include "client/bench/evaluation/room/room_evaluation.h"

#include <map>
#include <string_view>
#include <utility>

#include <absl/strings/str_format.h>

#include "client/bench/evaluation/method/method_run.h"
#include "client/bench/evaluation/score/map_score.h"
#include "client/bench/simulator/simulation.h"
#include "core/types/absl_text.h"

namespace steadymap {
namespace {

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
  Method method;
  method.config = MapConfigFor(room_case, evaluation.policy);
  method.config.parameters = evaluation.parameters;
  absl::StatusOr<MethodRun> run = MethodRun::Start(method);
  if (!run.ok()) return run.status();
  const BoxRoom room = MakeBoxRoom(room_case.change, room_case.setting);
  SimulationOptions options;
  options.sensor = room_case.sensor;
  options.seed = room_case.seed;
  options.include_instances = room_case.labels == RoomLabels::kInstances;
  Simulation simulation(room.route, options);
  CameraPath truth;
  CameraPath claimed;
  for (std::size_t i = 0; i < simulation.frame_count(); ++i) {
    Frame frame = simulation.Render(i);
    if (room_case.labels == RoomLabels::kNone) frame.labels = {};
    truth.push_back({frame.capture_time, simulation.TruePose(i)});
    claimed.push_back({frame.capture_time, frame.T_world_camera});
    run->Integrate(frame, /*is_last_sequence=*/true);
    if (EndsSession(simulation, i)) run->EndSequence();
  }
  const MethodOutcome outcome = run->Finish(room_case.voxel_size_m);
  const RoomTolerance tolerance = ToleranceOf(room_case);
  return RoomResult{.room_case = room_case,
                    .score = ScoreRoom(room, outcome.events, *outcome.map, tolerance),
                    .cuboid_tolerance_m = tolerance.cuboid_m,
                    .claimed_poses = ScorePoses(truth, claimed),
                    .registered_poses = ScorePoses(truth, outcome.registered)};
}

/// Counts of the cases of one row.
struct RoomCounts {
  Share labelled;
  Share unlabelled;
  Share cuboids;  ///< Of all exact cases.
  PoseScore claimed;
  PoseScore registered;

  void Add(const RoomResult& result) {
    (result.is_labelled() ? labelled : unlabelled) += {result.score.is_exact() ? 1U : 0U, 1U};
    claimed += result.claimed_poses;
    registered += result.registered_poses;
    if (result.score.is_exact()) cuboids += {result.has_right_cuboids() ? 1U : 0U, 1U};
  }
};

std::string RowText(std::string_view name, const RoomCounts& counts) {
  return absl::StrFormat("%-26s | %12s | %12s | %12s | %7s %10s %6s\n",
                         Absl(name),
                         CountText(counts.labelled),
                         CountText(counts.unlabelled),
                         CountText(counts.cuboids),
                         MillimetreText(counts.claimed),
                         MillimetreText(counts.registered),
                         SigmaText(counts.registered));
}

std::string FaultText(const RoomResult& result) {
  std::string text = std::string(NameOf(result.room_case.change));
  for (const std::string& variation : result.room_case.variations) text += " " + variation;
  text += result.score.is_exact() ? ": exact" : ":";
  text += absl::StrFormat(", cuboids within %.0f mm, poses within %s of %s mm\n",
                          1e3 * result.score.worst_cuboid_m,
                          MillimetreText(result.registered_poses),
                          MillimetreText(result.claimed_poses));
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
    for (RoomCase& room_case :
         ListRoomCases(change, options.cases, options.seed, options.variations)) {
      if (options.labels) GiveLabels(*options.labels, &room_case);
      absl::StatusOr<RoomResult> result = EvaluateRoom(room_case, options);
      if (!result.ok()) return result.status();
      results.push_back(*std::move(result));
      if (options.on_case) options.on_case();
    }
  }
  if (results.empty()) {
    return absl::InvalidArgumentError("no change allows these variations and labels together");
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
  text += absl::StrFormat(
      "%-26s | %12s | %12s | %12s | %s\n%-26s | %12s | %12s | %12s | %7s %10s %6s\n",
      "",
      "",
      "",
      "",
      "poses, mm RMS",
      "exact",
      "labelled",
      "unlabelled",
      "cuboids",
      "claimed",
      "registered",
      "sigmas");
  for (const auto& [name, counts] : by_change) text += RowText(name, counts);
  for (const auto& [name, counts] : by_variation) text += RowText("with " + name, counts);
  return text + RowText("all", all);
}

}  // namespace steadymap
