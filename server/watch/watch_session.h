#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <grpcpp/support/byte_buffer.h>

#include "core/types/cancellation.h"
#include "server/mapping/map_directory.h"
#include "server/watch/watch_hub.h"

#include "steadymap/v1/watch_service.pb.h"

namespace steadymap {

/// What one watch is sent, message by message: where it begins, and the steps that it takes from
/// there. It holds what the watcher has, and of a step on its way the place in it. Knows nothing of
/// how messages travel. For one thread at a time.
class WatchSession {
 public:
  /// A message to send; none if there is nothing to say now.
  using Message = std::optional<grpc::ByteBuffer>;

  /// Both outlive the course. Long work ends early once the watcher has gone.
  WatchSession(const MapDirectory* maps,
               WatchHub* hub,
               v1::WatchMapRequest request,
               Cancellation cancellation);

  /// To be called first. Errors: what is wrong with the request, its token aside.
  absl::Status ReadRequest();

  /// The map, once the request has been read; it may not be open yet.
  const std::shared_ptr<MapRuntime>& map() const { return map_; }

  /// To be called next, once the map is open and the hub tells of every commit from now on. The
  /// first message. Errors: why the watch cannot begin where its request says, or the map cannot be
  /// read.
  absl::StatusOr<Message> Begin();

  /// The next message. While the server drains, the last ones are a goodbye and then the error that
  /// ends the watch. Errors: why it ends.
  absl::StatusOr<Message> Next(bool draining);

  /// What the watcher has, or is about to get as a snapshot.
  const WatchPosition& position() const { return position_; }

  /// The step on its way; null between steps.
  const std::shared_ptr<WatchMessages>& step() const { return step_; }

  /// The steps of which the watcher may have a part, and a token for going on within them: the one
  /// on its way, and the one sent last, since what was sent may be lost on its way.
  std::vector<std::shared_ptr<WatchMessages>> StepsInPart() const;

 private:
  absl::Status ChooseStart(const PublishedRevision& newest);
  void BeginSnapshot(const PublishedRevision& newest);
  void RepeatPosition(const PublishedRevision& newest);
  absl::Status ResumeBehindToken(const PublishedRevision& newest);
  bool ContinueStep(const ResumeToken& token, const PublishedRevision& newest);
  absl::Status TakeFirstStep(const PublishedRevision& newest);
  absl::Status FindStep(const PublishedRevision& newest);
  absl::StatusOr<Message> NextOfStep();
  absl::StatusOr<Message> TakeStep(const PublishedRevision& newest);
  absl::StatusOr<Message> HandleGap(const absl::Status& gap, const PublishedRevision& newest);
  grpc::ByteBuffer MakeCreated() const;

  const MapDirectory* const maps_;
  WatchHub* const hub_;
  const v1::WatchMapRequest request_;
  const Cancellation cancellation_;

  std::shared_ptr<MapRuntime> map_;
  WatchScope scope_;
  MapFilter filter_;
  std::size_t max_message_bytes_ = 0;
  WatchPosition position_;
  std::shared_ptr<const ShownObjects> shown_;       ///< At `position_`; null: not known.
  std::optional<PublishedRevision> next_snapshot_;  ///< To be sent whole; none: deltas follow.
  absl::Status gap_;  ///< Why the history behind the token is no use; to be told or resynced.
  std::shared_ptr<WatchMessages> step_;
  std::size_t place_ = 0;                   ///< Of the next message in the step.
  std::weak_ptr<WatchMessages> sent_step_;  ///< The last one with tokens; the hub keeps some.
  bool continues_step_ = false;             ///< The watcher has part of the first step.
  bool said_goodbye_ = false;
};

}  // namespace steadymap
