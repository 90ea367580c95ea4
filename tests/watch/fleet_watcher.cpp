#include "tests/watch/fleet_watcher.h"

#include <utility>

#include "core/types/error.h"
#include "proto/convert_watch.h"
#include "proto/grpc_status.h"

#include "steadymap/v1/watch_service.grpc.pb.h"

namespace steadymap {
namespace {

// So that steps take several messages.
constexpr std::uint32_t kSmallMessageBytes = 65'536;

// One in this many messages within a step is followed by a cancellation.
constexpr std::uint32_t kCutWithinStepOneIn = 4;

/// Returns a filter: everything, half of the view, goods only, the background only, or events only.
MapFilter DrawFilter(std::mt19937* random) {
  MapFilter filter;
  switch ((*random)() % 6) {
    case 0:
      filter.boxes_world = {Box(Eigen::Vector3d(0.0, -3.0, -2.0), Eigen::Vector3d(3.0, 0.0, 2.0))};
      break;
    case 1:
      filter.classes = {ClassId(7)};
      filter.archived = true;
      break;
    case 2:
      filter.objects = {kBackgroundId, ObjectId(1), ObjectId(3)};
      break;
    case 3:
      filter.states = filter.volumes = false;
      break;
    case 4:
      filter.events = filter.volumes = false;
      break;
    default:
      break;
  }
  return filter;
}

}  // namespace

FleetWatcher::FleetWatcher(const FleetServer* server, std::uint32_t seed)
    : server_(server), random_(seed) {
  {
    const absl::MutexLock lock(&mutex_);
    NewMind();
  }
  thread_ = std::thread([this] { Run(); });
}

FleetWatcher::~FleetWatcher() {
  if (thread_.joinable()) Stop();
}

void FleetWatcher::NewMind() {
  filter_ = DrawFilter(&random_);
  // A watch from now on has no complete content to compare.
  from_now_ = !filter_.WantsObjects() && random_() % 2 == 0;
  resyncs_ = random_() % 2 == 0;
  takes_patches_ = !from_now_ && random_() % 3 > 0;
  keeps_parts_ = random_() % 3 > 0;
  changed_mind_ = true;
}

void FleetWatcher::Cut() {
  const absl::MutexLock lock(&mutex_);
  if (context_ != nullptr) context_->TryCancel();
}

void FleetWatcher::Stall() {
  const absl::MutexLock lock(&mutex_);
  stalled_ = true;
}

void FleetWatcher::Resume() {
  const absl::MutexLock lock(&mutex_);
  stalled_ = false;
}

void FleetWatcher::ChangeMind() {
  const absl::MutexLock lock(&mutex_);
  NewMind();
  if (context_ != nullptr) context_->TryCancel();
}

WatchLife FleetWatcher::Stop() {
  {
    const absl::MutexLock lock(&mutex_);
    stopping_ = true;
    if (context_ != nullptr) context_->TryCancel();
  }
  thread_.join();
  return life_;
}

void FleetWatcher::Run() {
  while (true) {
    {
      const absl::MutexLock lock(&mutex_);
      if (stopping_) break;
    }
    RunStream();
  }
  if (promises_ != nullptr) Conclude();
}

/// Runs one stream, from its request to its end.
void FleetWatcher::RunStream() {
  v1::WatchMapRequest request;
  grpc::ClientContext context;
  request.set_map(server_->map());
  bool begins_anew = false;
  {
    const absl::MutexLock lock(&mutex_);
    begins_anew = std::exchange(changed_mind_, false);
    if (begins_anew) {
      if (promises_ != nullptr) Conclude();
      promises_ = std::make_unique<WatchPromises>(filter_, &server_->history(), server_->scale());
      revision_ = 0;
    }
    *request.mutable_filter() = ToProto(filter_);
    request.set_resync_if_compacted(resyncs_);
    request.set_takes_patches(takes_patches_);
    request.set_max_message_bytes(kSmallMessageBytes);
    if (keeps_parts_ && !promises_->part_token().empty()) {
      request.set_resume_token(promises_->part_token());
      begin_ = WatchPromises::Begin::kWithinStep;
    } else if (promises_->progress()) {
      request.set_resume_token(promises_->progress()->resume_token());
      begin_ = WatchPromises::Begin::kResumed;
    } else {
      request.set_start(from_now_ ? v1::WATCH_START_NOW : v1::WATCH_START_SNAPSHOT_THEN_FOLLOW);
      begin_ = from_now_ ? WatchPromises::Begin::kNow : WatchPromises::Begin::kSnapshot;
    }
    context_ = &context;
  }
  ++life_.streams;
  life_.resumed += request.resume_token().empty() ? 0 : 1;
  promises_->BeginStream(begin_);
  const auto stream = v1::WatchService::NewStub(server_->Connect())->WatchMap(&context, request);
  v1::WatchMapResponse message;
  bool is_cut = false;
  while (stream->Read(&message)) {
    // Messages in flight after the cancellation.
    if (is_cut) continue;
    promises_->Take(message);
    if (message.has_progress()) revision_ = message.progress().revision();
    const absl::MutexLock lock(&mutex_);
    is_cut = !promises_->part_token().empty() && random_() % kCutWithinStepOneIn == 0;
    if (is_cut) context.TryCancel();
    mutex_.Await(absl::Condition(this, &FleetWatcher::MayRead));
  }
  const absl::Status status = FromGrpcStatus(stream->Finish());
  const absl::MutexLock lock(&mutex_);
  context_ = nullptr;
  if (changed_mind_ || stopping_) return;
  if (ReasonOf(status) == reason::kRevisionCompacted || ReasonOf(status) == reason::kSlowConsumer) {
    // The gap was reported, not silent: the watcher restarts.
    ++life_.gaps_told;
    changed_mind_ = true;
    if (resyncs_) life_.broken.emplace_back("Resumable: no resync where one was asked for");
  } else if (!absl::IsUnavailable(status) && !absl::IsCancelled(status)) {
    life_.broken.push_back("a stream ended with " + status.ToString());
  }
}

/// Adds the results of the promises to the watcher's results.
void FleetWatcher::Conclude() {
  life_.steps += promises_->steps();
  life_.jumps += promises_->jumps();
  life_.patches += promises_->patches();
  life_.continued += promises_->continued();
  life_.events += promises_->events();
  life_.resyncs += promises_->resyncs();
  life_.broken.insert(life_.broken.end(), promises_->broken().begin(), promises_->broken().end());
}

}  // namespace steadymap
