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

/// The sequence of messages of one watch: its start, and the steps from there. Stores the position
/// of the watcher and the index of the next message in the current step. Independent of the
/// transport. Not thread-safe.
class WatchSession {
 public:
  /// A message to send; none if there is nothing to send now.
  using Message = std::optional<grpc::ByteBuffer>;

  /// `maps` and `hub` must outlive the session. Long work stops early on cancellation.
  WatchSession(const MapDirectory* maps,
               WatchHub* hub,
               v1::WatchMapRequest request,
               Cancellation cancellation);

  /// Checks the request except for its token, and finds the map. Must be called first. Errors:
  /// those of an invalid request.
  absl::Status ReadRequest();

  /// Returns the map after `ReadRequest`; it may not be open yet.
  const std::shared_ptr<MapRuntime>& map() const { return map_; }

  /// Returns the first message. Must be called after `ReadRequest`, when the map is open and the
  /// watch is in the hub, so that no commit is missed. Errors: an invalid start or token of the
  /// request; a map that cannot be read.
  absl::StatusOr<Message> Begin();

  /// Returns the next message. While the server drains, returns a goodbye after the last committed
  /// revision, and then the error that ends the watch. Errors: the reason for the end of the watch.
  absl::StatusOr<Message> Next(bool draining);

  /// Returns the position of the watcher; before a snapshot is sent, the revision of the snapshot.
  const WatchPosition& position() const { return position_; }

  /// Returns the current step; null between steps.
  const std::shared_ptr<WatchMessages>& step() const { return step_; }

  /// Returns the steps within which the watcher may resume: the current one, and the last one sent,
  /// because sent messages can be lost in transit.
  std::vector<std::shared_ptr<WatchMessages>> StepsInPart() const;

 private:
  absl::Status ChooseStart(const PublishedRevision& newest);
  void BeginSnapshot(const PublishedRevision& newest);
  void SendEmptyStep(const PublishedRevision& newest);
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
  std::shared_ptr<const ShownObjects> shown_;  ///< Objects shown at `position_`; null: unknown.
  std::optional<PublishedRevision> next_snapshot_;  ///< Snapshot to send; none: deltas follow.
  absl::Status gap_;  ///< Why the history after the token is missing; reported or resynced.
  std::shared_ptr<WatchMessages> step_;
  std::size_t place_ = 0;                   ///< Index of the next message in the step.
  std::weak_ptr<WatchMessages> sent_step_;  ///< The last step with tokens; the hub owns some.
  bool continues_step_ = false;             ///< The watcher has a part of the first step.
  bool goodbye_sent_ = false;
};

}  // namespace steadymap
