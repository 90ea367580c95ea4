#include "client/bench/evaluation/composite/composite_evaluation.h"

#include <map>
#include <memory>
#include <optional>
#include <utility>

#include <absl/strings/str_format.h>

#include "client/bench/evaluation/composite/frame_composer.h"
#include "client/bench/evaluation/composite/upright.h"
#include "client/bench/simulator/scene/counter_random.h"
#include "core/association/sample_grid.h"
#include "core/integration/semantic_cloud.h"
#include "proto/convert_frame.h"

namespace steadymap {
namespace {

const SensorName kRecordingSource{"recording", SensorName::kDefaultSensor};

constexpr std::int64_t kPauseOfDrivesNs = 60'000'000'000;  // Between both drives.
constexpr std::size_t kViews = 30;

/// The frames of a recording, as two drives.
class TwoDrives {
 public:
  TwoDrives(std::unique_ptr<DatasetSource> source,
            const MapConfig& config,
            const CompositeEvaluationOptions& options)
      : source_(std::move(source)), labels_(config.classes), options_(options) {}

  std::size_t frame_count() const { return source_->frame_count(); }

  void TurnUpright(const Eigen::Quaterniond& rotation) { rotation_ = rotation; }

  /// Returns the frame at a position of both drives together, turned upright.
  absl::StatusOr<Frame> Read(std::size_t position) const {
    const std::size_t index = IndexOf(position);
    const absl::StatusOr<v1::Frame> message = source_->Read(index);
    if (!message.ok()) return message.status();
    absl::StatusOr<Frame> frame = FromProto(*message, kRecordingSource, labels_);
    if (!frame.ok()) return frame;
    frame->T_world_camera = rotation_ * frame->T_world_camera;
    frame->color = {};
    if (options_.on_frame) options_.on_frame(CountReads());
    return frame;
  }

  bool IsSecond(std::size_t position) const { return position >= first_count(); }

  std::size_t first_count() const { return (frame_count() + 1) / 2; }

  /// Returns a step between frames of which there are about `kViews`.
  std::size_t view_step() const { return frame_count() / kViews + 1; }

 private:
  /// Returns the number of frames that all cases read: the views, the room, and each case.
  std::size_t CountReads() const {
    return (frame_count() + view_step() - 1) / view_step() + frame_count() * (options_.cases + 2);
  }

  std::size_t IndexOf(std::size_t position) const {
    return IsSecond(position) ? 2 * (position - first_count()) + 1 : 2 * position;
  }

  std::unique_ptr<DatasetSource> source_;
  KnownLabels labels_;
  const CompositeEvaluationOptions& options_;
  Eigen::Quaterniond rotation_ = Eigen::Quaterniond::Identity();
};

/// The evaluation of one recording.
class CompositeEvaluation {
 public:
  CompositeEvaluation(const CompositeEvaluationOptions& options,
                      std::unique_ptr<DatasetSource> source)
      : options_(options),
        config_(options.methods.front().config),
        drives_(std::move(source), config_, options) {}

  absl::Status Prepare() {
    room_.sensor = StructuredLightModel();
    room_.spacing_m = config_.voxel_size_m;
    room_.max_depth_m = config_.max_depth_m;
    if (absl::Status status = TurnUpright(); !status.ok()) return status;
    return FuseRoom();
  }

  absl::Status RunCase(std::size_t number, std::vector<CompositeResult>* results) {
    CompositeTruth truth;
    if (number > 0) truth.things = MakeCompositeCase(room_, Combine(options_.seed, number));
    if (number > 0 && truth.things.things.empty()) {
      return absl::FailedPreconditionError(
          "expected level surface with place for things, in view of most frames, but found none");
    }
    const ClassId goods(static_cast<std::uint16_t>(SceneClass::kGoods));
    truth.events =
        ListCompositeEvents(truth.things, options_.labels == RoomLabels::kNone ? kNoClass : goods);
    truth.room = room_.surface;
    truth.spacing_m = room_.spacing_m;
    std::vector<MethodRun> runs;
    for (const Method& method : options_.methods) {
      absl::StatusOr<MethodRun> run = MethodRun::Start(method);
      if (!run.ok()) return run.status();
      runs.push_back(*std::move(run));
    }
    Play(Combine(options_.seed, number), &truth, &runs);
    for (std::size_t i = 0; i < runs.size(); ++i) {
      const MethodOutcome outcome = runs[i].Finish(0.5 * room_.spacing_m);
      results->push_back({number, options_.methods[i].name, ScoreComposite(truth, outcome)});
    }
    return absl::OkStatus();
  }

 private:
  /// Finds the upright frame, and keeps the views.
  absl::Status TurnUpright() {
    SemanticCloud cloud(config_);
    SampleGrid samples;
    std::vector<Eigen::Vector3f> normals;
    absl::Status first_error = absl::InvalidArgumentError("expected frames, but there is none");
    for (std::size_t i = 0; i < drives_.frame_count(); i += drives_.view_step()) {
      absl::StatusOr<Frame> frame = drives_.Read(i);
      if (!frame.ok()) {
        if (room_.views.empty()) first_error = frame.status();
        continue;
      }
      // As in `Play`: things are drawn for one camera.
      if (!room_.views.empty() && frame->camera != room_.views.front().camera) continue;
      cloud.Compute(*frame);
      samples.Compute(cloud);
      for (std::size_t j = 0; j < samples.size(); ++j) {
        if (samples[j].is_valid()) normals.push_back(samples[j].normal_world);
      }
      room_.views.push_back(*std::move(frame));
    }
    if (room_.views.empty()) return first_error;
    const Eigen::Quaterniond rotation = UprightRotation(normals);
    drives_.TurnUpright(rotation);
    for (Frame& view : room_.views) view.T_world_camera = rotation * view.T_world_camera;
    return absl::OkStatus();
  }

  /// Fuses the recording alone.
  absl::Status FuseRoom() {
    Method method{"static", config_};
    method.config.policy = UpdatePolicy::kStatic;
    method.config.parameters.clear();
    absl::StatusOr<MethodRun> run = MethodRun::Start(method);
    if (!run.ok()) return run.status();
    for (std::size_t i = 0; i < drives_.frame_count(); ++i) {
      const absl::StatusOr<Frame> frame = drives_.Read(i);
      if (frame.ok()) run->Integrate(*frame, true);
    }
    room_.surface = run->Finish(room_.spacing_m).surface;
    return absl::OkStatus();
  }

  /// Plays both drives with the things of a case. Notes the capture times in the truth.
  void Play(std::uint64_t key, CompositeTruth* truth, std::vector<MethodRun>* runs) {
    SensorModel poses = SensorModel::Ideal();
    poses.session_offset_m = options_.session_offset_m;
    const PinholeCamera& camera = room_.views.front().camera;
    FrameComposer before(&truth->things.before, camera, room_.sensor);
    FrameComposer after(&truth->things.after, camera, room_.sensor);
    std::optional<std::int64_t> first_ns;
    std::int64_t last_ns = 0;
    std::int64_t shift_ns = 0;
    for (std::size_t i = 0; i < drives_.frame_count(); ++i) {
      absl::StatusOr<Frame> frame = drives_.Read(i);
      if (!frame.ok() || frame->camera != camera) continue;
      const bool is_second = drives_.IsSecond(i);
      (is_second ? after : before).DrawInto(Combine(key, i), options_.labels, &*frame);
      const std::int64_t time_ns = frame->capture_time.nanoseconds();
      if (!first_ns) first_ns = time_ns;
      if (is_second && truth->events.first_frames.size() < 2) {
        EndDrive(truth, runs);
        shift_ns = last_ns + kPauseOfDrivesNs - *first_ns;
      }
      last_ns = time_ns + shift_ns;
      frame->capture_time = Timestamp::FromNanoseconds(last_ns);
      truth->recorded.push_back({frame->capture_time, frame->T_world_camera});
      frame->T_world_camera = OffsetPose(poses, key, is_second ? 1 : 0, frame->T_world_camera);
      truth->events.capture_times.push_back(frame->capture_time);
      for (MethodRun& run : *runs) run.Integrate(*frame, is_second);
    }
    EndDrive(truth, runs);
  }

  static void EndDrive(CompositeTruth* truth, std::vector<MethodRun>* runs) {
    std::vector<std::size_t>& first_frames = truth->events.first_frames;
    if (first_frames.empty()) first_frames.push_back(0);
    first_frames.push_back(truth->events.capture_times.size());
    for (MethodRun& run : *runs) run.EndSequence();
  }

  const CompositeEvaluationOptions& options_;
  const MapConfig& config_;
  TwoDrives drives_;
  RecordedRoom room_;
};

std::string PercentText(const Share& share) {
  if (share.whole == 0) return "-";
  return absl::StrFormat("%.1f %%", 100.0 * share.value());
}

std::string RowText(const std::string& name, const CompositeScore& score) {
  const std::uint64_t false_claims = score.events.right.whole - score.events.right.part;
  return absl::StrFormat("%-22s | %10s | %5d | %8s | %8s | %8s | %8s | %7s | %6s\n",
                         name,
                         CountText(score.events.found),
                         false_claims,
                         CountText(score.moves),
                         CountText(score.cuboids),
                         PercentText(score.ghosts),
                         PercentText(score.kept),
                         MillimetreText(score.poses),
                         SigmaText(score.poses));
}

}  // namespace

absl::StatusOr<std::vector<CompositeResult>> EvaluateComposite(
    const CompositeEvaluationOptions& options) {
  absl::StatusOr<std::unique_ptr<DatasetSource>> source =
      OpenDataset(options.format, {options.path}, options.dataset);
  if (!source.ok()) return source.status();
  CompositeEvaluation evaluation(options, *std::move(source));
  if (absl::Status status = evaluation.Prepare(); !status.ok()) return status;
  std::vector<CompositeResult> results;
  for (std::size_t i = 0; i <= options.cases; ++i) {
    if (absl::Status status = evaluation.RunCase(i, &results); !status.ok()) return status;
  }
  return results;
}

std::string CompositeTable(const std::vector<CompositeResult>& results, bool with_faults) {
  std::string text = absl::StrFormat("%-22s | %10s | %5s | %8s | %8s | %8s | %8s | %7s | %6s\n",
                                     "case",
                                     "changes",
                                     "false",
                                     "moves",
                                     "cuboids",
                                     "ghosts",
                                     "kept",
                                     "pose mm",
                                     "sigmas");
  std::map<std::string, CompositeScore> by_method;
  for (const CompositeResult& result : results) {
    const std::string name =
        result.number == 0 ? "no things" : absl::StrFormat("case %d", result.number);
    text += RowText(name + ", " + result.method, result.score);
    if (with_faults) {
      for (const std::string& fault : result.score.faults) text += "  " + fault + "\n";
    }
    by_method[result.method] += result.score;
  }
  for (const auto& [method, score] : by_method) {
    text += RowText("all, " + method, score);
    text += absl::StrFormat("%-22s | F1 %.1f\n", "", 100.0 * score.events.f1());
  }
  return text;
}

}  // namespace steadymap
