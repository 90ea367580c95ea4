#include "client/evaluation/method_run.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/map_counts.h"

namespace steadymap {
namespace {

// About what a daemon does at the rate of a live robot.
constexpr std::size_t kFramesACommit = 15;

double Median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

absl::StatusOr<MethodRun> MethodRun::Start(const Method& method) {
  absl::StatusOr<std::unique_ptr<Mapper>> mapper = Mapper::Create(method.config);
  if (!mapper.ok()) return mapper.status();
  return MethodRun(method, *std::move(mapper));
}

MethodRun::MethodRun(const Method& method, std::unique_ptr<Mapper> mapper)
    : last_sequence_only_(method.last_sequence_only), mapper_(std::move(mapper)) {}

void MethodRun::Integrate(const Frame& frame, bool is_last_sequence) {
  if (last_sequence_only_ && !is_last_sequence) return;
  const auto start = std::chrono::steady_clock::now();
  mapper_->Integrate(mapper_->head().Next(), frame);
  const std::chrono::duration<double, std::milli> elapsed =
      std::chrono::steady_clock::now() - start;
  frame_ms_.push_back(elapsed.count());
  if (mapper_->uncommitted_frames() >= kFramesACommit) Commit();
}

void MethodRun::Commit() {
  MapCommit commit = mapper_->Commit();
  snapshot_ = std::move(commit.snapshot);
  events_.insert(events_.end(), commit.delta.events.begin(), commit.delta.events.end());
}

MethodOutcome MethodRun::Finish(double spacing_m) {
  Commit();
  return {.surface = SampleMap(*snapshot_, spacing_m),
          .events = std::move(events_),
          .memory_bytes = VolumeBytes(*snapshot_),
          .median_frame_ms = Median(std::move(frame_ms_))};
}

}  // namespace steadymap
