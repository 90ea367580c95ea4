#include "client/bench/evaluation/method/method_run.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/map/map_counts.h"

namespace steadymap {
namespace {

// About the commit rate of a daemon at the frame rate of a live robot.
constexpr std::size_t kFramesACommit = 15;

double Median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Keys and stamps are small compared with the evidence and the masks.
std::size_t BytesOf(const MapDelta& delta) {
  std::size_t bytes = delta.events.size() * sizeof(ObjectEvent);
  for (const LeafChange& leaf : delta.leaves) bytes += sizeof(LeafKey) + leaf.packed.size();
  for (const ObjectChange& object : delta.objects) {
    bytes += sizeof(ObjectId);
    if (!object.state.has_value()) continue;
    bytes += sizeof(ObjectState) + object.state->evidence.leaves.size() * sizeof(LeafEvidence);
  }
  return bytes + delta.free_blocks.size() * sizeof(FreeBlockChange);
}

double BytesPerObject(const MapSnapshot& map) {
  std::size_t bytes = 0;
  std::size_t objects = 0;
  for (const auto& [id, object] : map.objects) {
    if (object->status != ObjectStatus::kPresent) continue;
    bytes += object->volume->memory_bytes();
    ++objects;
  }
  return static_cast<double>(bytes) / static_cast<double>(objects);
}

}  // namespace

absl::StatusOr<MethodRun> MethodRun::Start(const Method& method) {
  auto clock = std::make_unique<StageClock>();
  absl::StatusOr<std::unique_ptr<Mapper>> mapper = Mapper::Create(method.config, clock.get());
  if (!mapper.ok()) return mapper.status();
  return MethodRun(method, std::move(clock), *std::move(mapper));
}

MethodRun::MethodRun(const Method& method,
                     std::unique_ptr<StageClock> clock,
                     std::unique_ptr<Mapper> mapper)
    : last_sequence_only_(method.last_sequence_only),
      has_sessions_(HasSessions(method.config.policy)),
      clock_(std::move(clock)),
      mapper_(std::move(mapper)) {}

void MethodRun::Integrate(const Frame& frame, bool is_last_sequence) {
  if (last_sequence_only_ && !is_last_sequence) return;
  source_ = frame.source;
  const auto start = std::chrono::steady_clock::now();
  mapper_->Integrate(mapper_->head().Next(), frame);
  const std::chrono::duration<double, std::milli> elapsed =
      std::chrono::steady_clock::now() - start;
  frame_ms_.push_back(elapsed.count());
  NoteRegisteredPose(frame);
  if (mapper_->uncommitted_entries() >= kFramesACommit) Commit();
}

// After a frame that is not used, the state still holds the pose error at an earlier one.
void MethodRun::NoteRegisteredPose(const Frame& frame) {
  const RobotState* robot = mapper_->FindRobot(frame.source);
  if (robot == nullptr || !robot->pose_error) return;
  if (robot->pose_error->time != frame.capture_time) return;
  const PoseError error = robot->pose_error->Combined();
  registered_.push_back(
      {frame.capture_time, error.Correct(frame.T_world_camera), error.covariance});
}

void MethodRun::EndSequence() {
  if (has_sessions_) mapper_->EndSession(mapper_->head().Next(), source_);
}

void MethodRun::Commit() {
  MapCommit commit = mapper_->Commit();
  delta_bytes_ += BytesOf(commit.delta);
  snapshot_ = std::move(commit.snapshot);
  events_.insert(events_.end(), commit.delta.events.begin(), commit.delta.events.end());
}

MethodOutcome MethodRun::Finish(double spacing_m) {
  Commit();
  const double frames = std::max(1.0, static_cast<double>(frame_ms_.size()));
  StageTimes stage_ms = clock_->total_ms();
  for (double& time_ms : stage_ms) time_ms /= frames;
  return {.map = snapshot_,
          .surface = SampleMap(*snapshot_, spacing_m),
          .events = std::move(events_),
          .registered = std::move(registered_),
          .cost = {.memory_bytes = CountMap(*snapshot_).memory_bytes,
                   .bytes_per_object = BytesPerObject(*snapshot_),
                   .delta_bytes_per_frame = static_cast<double>(delta_bytes_) / frames,
                   .median_frame_ms = Median(std::move(frame_ms_)),
                   .stage_ms = stage_ms}};
}

}  // namespace steadymap
