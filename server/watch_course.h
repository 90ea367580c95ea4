#pragma once

#include <cstddef>
#include <memory>
#include <optional>

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <grpcpp/support/byte_buffer.h>

#include "server/map_directory.h"
#include "server/watch_hub.h"

#include "steadymap/v1/watch_service.pb.h"

namespace steadymap {

/// What one watch is sent, message by message: where it begins, and the steps that it takes from
/// there. It holds what the watcher has, and of a step on its way the place in it. Knows nothing of
/// how messages travel. For one thread at a time.
class WatchCourse {
 public:
  /// A message to send; none if there is nothing to say now.
  using Message = std::optional<grpc::ByteBuffer>;

  /// Both outlive the course.
  WatchCourse(const MapDirectory* maps, WatchHub* hub, v1::WatchMapRequest request);

  /// To be called first. Errors: what is wrong with the request, its token aside.
  absl::Status ReadRequest();

  /// The map, once the request has been read.
  const std::shared_ptr<MapRuntime>& map() const { return map_; }

  /// To be called next, and only when the hub tells of every commit from now on. The first message.
  /// Errors: why the watch cannot begin where its request says; the condition of the map.
  absl::StatusOr<Message> Begin();

  /// The next message. While the server drains, the last ones are a goodbye and then the error that
  /// ends the watch. Errors: why it ends.
  absl::StatusOr<Message> Next(bool draining);

  /// What the watcher has, or is about to get as a snapshot.
  const WatchPosition& position() const { return position_; }

  /// The step on its way; null between steps.
  const std::shared_ptr<WatchMessages>& step() const { return step_; }

  /// Whether the watcher may have part of that step, and a token for going on within it.
  bool is_within_step() const { return step_ != nullptr && place_ > 0 && step_->is_resumable(); }

 private:
  absl::Status ChooseStart(const std::shared_ptr<const MapSnapshot>& snapshot);
  void BeginSnapshot(const std::shared_ptr<const MapSnapshot>& snapshot);
  void RepeatPosition(const std::shared_ptr<const MapSnapshot>& snapshot);
  absl::Status ResumeBehindToken(const std::shared_ptr<const MapSnapshot>& snapshot);
  bool ContinueStep(const ResumeToken& token, const std::shared_ptr<const MapSnapshot>& snapshot);
  absl::Status TakeFirstStep(const std::shared_ptr<const MapSnapshot>& snapshot);
  absl::Status FindStep(const std::shared_ptr<const MapSnapshot>& snapshot);
  absl::StatusOr<Message> NextOfStep();
  absl::StatusOr<Message> TakeStep(const std::shared_ptr<const MapSnapshot>& snapshot);
  absl::StatusOr<Message> HandleGap(const absl::Status& gap,
                                    const std::shared_ptr<const MapSnapshot>& snapshot);
  grpc::ByteBuffer MakeCreated() const;

  const MapDirectory* const maps_;
  WatchHub* const hub_;
  const v1::WatchMapRequest request_;

  std::shared_ptr<MapRuntime> map_;
  WatchScope scope_;
  MapFilter filter_;
  std::size_t max_message_bytes_ = 0;
  WatchPosition position_;
  std::shared_ptr<const ShownObjects> shown_;         ///< At `position_`; null: not known.
  std::shared_ptr<const MapSnapshot> next_snapshot_;  ///< To be sent whole; null: deltas follow.
  absl::Status gap_;  ///< Why the history behind the token is no use; to be told or resynced.
  std::shared_ptr<WatchMessages> step_;
  std::size_t place_ = 0;        ///< Of the next message in the step.
  bool continues_step_ = false;  ///< The watcher has part of the first step.
  bool said_goodbye_ = false;
};

}  // namespace steadymap
