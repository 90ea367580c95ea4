#include "client/bench/evaluation/recording_evaluation.h"

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "client/bench/evaluation/method/method_run.h"
#include "client/bench/evaluation/route_evaluation.h"
#include "proto/convert_frame.h"

namespace steadymap {
namespace {

const SensorName kSource{"recording", SensorName::kDefaultSensor};

// Pause between the end of a sequence and the start of one with shifted times.
constexpr std::int64_t kPauseNs = 1'000'000'000;

/// Plays sequences one after the other, with their times shifted so that they never decrease.
class RecordingPlayer {
 public:
  RecordingPlayer(const RecordingEvaluationOptions& options, std::vector<MethodRun>* runs)
      : options_(options),
        config_(options.methods.front().config),
        labels_(config_.classes),
        observed_(options.voxel_size_m, config_.max_depth_m),
        runs_(runs) {}

  // Plays the sequence at `path`.
  absl::Status Play(const std::filesystem::path& path, bool is_last) {
    const absl::StatusOr<std::unique_ptr<DatasetSource>> source =
        OpenDataset(options_.format, {path}, options_.dataset);
    if (!source.ok()) return source.status();
    skipped_count_ += (*source)->skipped_count();
    const std::size_t first_count = frame_count_;
    std::optional<std::int64_t> shift_ns;
    absl::Status first_error;
    while (true) {
      absl::StatusOr<std::optional<v1::Frame>> message = (*source)->Next();
      if (message.ok() && !message->has_value()) break;
      absl::StatusOr<Frame> frame = message.ok() ? FromProto(**message, kSource, labels_)
                                                 : absl::StatusOr<Frame>(message.status());
      if (!frame.ok()) {
        ++skipped_count_;
        if (first_error.ok()) first_error = frame.status();
        continue;
      }
      const std::int64_t time_ns = frame->capture_time.nanoseconds();
      if (!shift_ns.has_value()) {
        shift_ns = time_ns > end_ns_ ? 0 : end_ns_ + kPauseNs - time_ns;
      }
      end_ns_ = std::max(end_ns_, time_ns + *shift_ns);
      frame->capture_time = Timestamp::FromNanoseconds(time_ns + *shift_ns);
      Take(*frame, is_last);
    }
    if (frame_count_ > first_count) return absl::OkStatus();
    return absl::InvalidArgumentError(path.string() + ": expected frames, but none is usable: " +
                                      std::string(first_error.message()));
  }

  std::size_t frame_count() const { return frame_count_; }

  std::size_t skipped_count() const { return skipped_count_; }

  ObservedSpace& observed() { return observed_; }

 private:
  void Take(const Frame& frame, bool is_last) {
    ++frame_count_;
    for (MethodRun& run : *runs_) run.Integrate(frame, is_last);
    if (is_last) observed_.AddView(ViewOf(frame));
  }

  const RecordingEvaluationOptions& options_;
  const MapConfig& config_;
  const KnownLabels labels_;
  ObservedSpace observed_;  // By the last sequence.
  std::vector<MethodRun>* runs_;
  std::int64_t end_ns_ = std::numeric_limits<std::int64_t>::min();
  std::size_t frame_count_ = 0;
  std::size_t skipped_count_ = 0;
};

std::vector<MethodOutcome> FinishAll(double spacing_m, std::vector<MethodRun>* runs) {
  std::vector<MethodOutcome> outcomes;
  outcomes.reserve(runs->size());
  for (MethodRun& run : *runs) outcomes.push_back(run.Finish(spacing_m));
  return outcomes;
}

// Returns the index of the method whose map is the truth.
std::size_t TruthRow(const std::vector<Method>& methods) {
  const auto found = std::find_if(methods.begin(), methods.end(), [](const Method& method) {
    return method.last_sequence_only;
  });
  assert(found != methods.end());
  return static_cast<std::size_t>(found - methods.begin());
}

}  // namespace

absl::StatusOr<Evaluation> EvaluateRecording(const RecordingEvaluationOptions& options) {
  if (options.sequences.empty()) {
    return absl::InvalidArgumentError("expected the path of at least one sequence");
  }
  std::vector<MethodRun> runs;
  for (const Method& method : options.methods) {
    absl::StatusOr<MethodRun> run = MethodRun::Start(method);
    if (!run.ok()) return run.status();
    runs.push_back(*std::move(run));
  }
  RecordingPlayer player(options, &runs);
  for (std::size_t i = 0; i < options.sequences.size(); ++i) {
    const absl::Status status =
        player.Play(options.sequences[i], i + 1 == options.sequences.size());
    if (!status.ok()) return status;
    for (MethodRun& run : runs) run.EndSequence();
  }
  const std::vector<MethodOutcome> outcomes =
      FinishAll(SampleSpacingFor(options.voxel_size_m), &runs);

  Reference reference{.observed = std::move(player.observed())};
  reference.seen = outcomes[TruthRow(options.methods)].surface;
  const MapScorer scorer(std::move(reference));
  Evaluation evaluation;
  evaluation.title = options.format;
  evaluation.voxel_size_m = options.voxel_size_m;
  evaluation.frame_count = player.frame_count();
  evaluation.skipped_count = player.skipped_count();
  evaluation.scored_voxels = scorer.scored_voxels();
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    MethodScore& row = evaluation.rows.emplace_back();
    row.name = options.methods[i].name;
    row.last_sequence_only = options.methods[i].last_sequence_only;
    row.map = scorer.Score(outcomes[i].surface);
    row.cost = outcomes[i].cost;
    if (options.visit_map) options.visit_map(row.name, scorer, outcomes[i]);
  }
  return evaluation;
}

}  // namespace steadymap
