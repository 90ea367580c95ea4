#include "client/upload/upload_session.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include <absl/strings/str_cat.h>
#include <absl/time/time.h>

#include "client/transport/server_answer.h"
#include "client/upload/upload_retry.h"
#include "core/types/error.h"
#include "proto/grpc_status.h"

namespace steadymap {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kConfirmationTimeout{30};

UploaderOptions Complete(UploaderOptions options) {
  while (options.seed == 0) {
    std::random_device device;
    options.seed = (std::uint64_t{device()} << 32) | device();
  }
  if (options.session.empty()) {
    options.session = absl::StrCat("upload-", absl::Hex(options.seed, absl::kZeroPad16));
  }
  return options;
}

LossRecovery RecoveryOf(const UploaderOptions& options) {
  if (options.read_again) return LossRecovery::kSendAgain;
  return options.on_lost ? LossRecovery::kGoOn : LossRecovery::kNone;
}

// Returns a measure of the upload's progress, to decide whether a stream achieved anything.
std::uint64_t Advance(const UploadProgress& progress) {
  return progress.durable + progress.integrated + progress.refused;
}

}  // namespace

FrameUploader::Session::Session(ChannelOpener open_channel,
                                const MapName& map,
                                UploaderOptions options)
    : map_(map.ToString()),
      options_(Complete(std::move(options))),
      open_channel_(std::move(open_channel)),
      queue_(options_.max_batch_bytes, options_.max_batch_frames, RecoveryOf(options_)),
      thread_([this] { Run(); }) {}

FrameUploader::Session::~Session() {
  {
    const absl::MutexLock lock(&mutex_);
    cancelled_ = true;
    if (stream_.context != nullptr) stream_.context->TryCancel();
  }
  thread_.join();
}

absl::Status FrameUploader::Session::Push(v1::Frame frame) {
  const absl::MutexLock lock(&mutex_);
  mutex_.Await(absl::Condition(this, &Session::HasRoom));
  if (done_ && !result_.ok()) return result_;
  if (finishing_) return absl::FailedPreconditionError("the upload is already finished");
  queue_.Push(std::move(frame));
  return absl::OkStatus();
}

absl::StatusOr<UploadSummary> FrameUploader::Session::Finish() {
  const absl::MutexLock lock(&mutex_);
  finishing_ = true;
  mutex_.Await(absl::Condition(&done_));
  if (!result_.ok()) return result_;
  UploadSummary summary{queue_.progress(), queue_.refused(), queue_.lost()};
  summary.progress.reconnections = reconnections_;
  return summary;
}

UploadProgress FrameUploader::Session::progress() const {
  const absl::MutexLock lock(&mutex_);
  UploadProgress progress = queue_.progress();
  progress.reconnections = reconnections_;
  return progress;
}

void FrameUploader::Session::Run() {
  Backoff backoff(options_.backoff, options_.seed);
  absl::Status status;
  for (bool again = true; again;) {
    const std::uint64_t advance_before = Advance(progress());
    const Clock::time_point start = Clock::now();
    status = RunStream();
    if (Advance(progress()) > advance_before) backoff.Reset();
    const FailedTry failed = DescribeFailure(
        status, std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - start));
    again = IsWorthRetrying(status) && WaitBeforeRetry(status, failed, &backoff);
  }
  const absl::MutexLock lock(&mutex_);
  result_ = status;
  done_ = true;
}

FailedTry FrameUploader::Session::DescribeFailure(const absl::Status& status,
                                                  std::chrono::milliseconds took) const {
  const absl::MutexLock lock(&mutex_);
  FailedTry failed;
  failed.was_answered = stream_.closed || IsServerAnswer(status);
  failed.asked = std::chrono::milliseconds(RetryDelayMsOf(status));
  // An opened stream may have been idle for hours, so its duration does not count. A replaced
  // `sleep` also replaces the clock.
  if (!stream_.opened && !options_.sleep) failed.took = took;
  return failed;
}

// Returns true if the upload shall be tried again.
bool FrameUploader::Session::WaitBeforeRetry(const absl::Status& status,
                                             const FailedTry& failed,
                                             Backoff* backoff) {
  const std::optional<std::chrono::milliseconds> delay = backoff->NextDelay(failed);
  if (!delay) return false;
  if (options_.on_retry) options_.on_retry(status, *delay);
  if (options_.sleep) options_.sleep(*delay);
  const absl::MutexLock lock(&mutex_);
  if (!options_.sleep) {
    mutex_.AwaitWithTimeout(absl::Condition(&cancelled_), absl::FromChrono(*delay));
  }
  ++reconnections_;
  return !cancelled_;
}

absl::Status FrameUploader::Session::RunStream() {
  grpc::ClientContext context;
  if (!BeginStream(&context)) return absl::CancelledError("the upload was cancelled");
  const std::shared_ptr<grpc::ChannelInterface> channel = open_channel_();
  const auto stub = v1::IngestService::NewStub(channel);
  const std::unique_ptr<Stream> stream = stub->UploadFrames(&context);
  stream->Write(OpenMessage());
  std::thread reader([this, &stream] { ReadResponses(stream.get()); });
  if (AwaitOpened()) WriteBatches(stream.get());
  reader.join();
  absl::Status status = FromGrpcStatus(stream->Finish());
  {
    const absl::MutexLock lock(&mutex_);
    stream_.context = nullptr;
    stream_.closed = status.ok();
    if (cancelled_) return absl::CancelledError("the upload was cancelled");
    if (!stream_.error.ok()) return stream_.error;
  }
  return status.ok() ? ConfirmIntegration(channel) : status;
}

bool FrameUploader::Session::BeginStream(grpc::ClientContext* context) {
  const absl::MutexLock lock(&mutex_);
  if (cancelled_) return false;
  stream_ = StreamState();
  stream_.context = context;
  return true;
}

v1::UploadFramesRequest FrameUploader::Session::OpenMessage() const {
  v1::UploadFramesRequest message;
  v1::UploadOpen& open = *message.mutable_open();
  open.set_map(map_);
  open.set_robot(options_.robot);
  open.set_sensor(options_.sensor);
  open.set_session(options_.session);
  open.add_ack_levels(v1::ACK_LEVEL_DURABLE);
  open.add_ack_levels(v1::ACK_LEVEL_INTEGRATED);
  const absl::MutexLock lock(&mutex_);
  open.set_last_durable_client_seq(queue_.durable_client_seq());
  return message;
}

bool FrameUploader::Session::AwaitOpened() {
  const absl::MutexLock lock(&mutex_);
  if (!mutex_.AwaitWithTimeout(absl::Condition(this, &Session::OpeningIsOver),
                               absl::FromChrono(options_.open_timeout))) {
    FailStream(absl::DeadlineExceededError(
        absl::StrCat("the server did not answer the opening of the upload within ",
                     options_.open_timeout.count(),
                     " ms")));
  }
  return stream_.opened;
}

void FrameUploader::Session::WriteBatches(Stream* stream) {
  for (;;) {
    std::optional<OutgoingBatch> batch;
    std::optional<std::uint64_t> missing;
    {
      const absl::MutexLock lock(&mutex_);
      mutex_.Await(absl::Condition(this, &Session::WriterHasWork));
      if (stream_.ended || cancelled_) return;
      missing = queue_.FrameToReadAgain();
    }
    if (missing) {
      if (!ReadAgain(*missing)) return;
      continue;
    }
    {
      const absl::MutexLock lock(&mutex_);
      absl::StatusOr<std::optional<OutgoingBatch>> next = queue_.TakeBatch();
      if (!next.ok()) return FailStream(next.status());
      if (next->has_value()) batch.emplace(std::move(**next));
    }
    // All frames are sent and no more will be pushed.
    if (!batch) break;
    if (!stream->Write(batch->message())) return;
  }
  stream->WritesDone();
}

// Returns true if the stream can continue.
bool FrameUploader::Session::ReadAgain(std::uint64_t client_seq) {
  absl::StatusOr<v1::Frame> frame = options_.read_again(client_seq);
  const absl::MutexLock lock(&mutex_);
  if (frame.ok()) {
    queue_.FillIn(client_seq, *std::move(frame));
    return true;
  }
  FailStream(MakeError(absl::StatusCode::kDataLoss,
                       {},
                       absl::StrCat("the server lost frame ",
                                    client_seq,
                                    ", which it had acknowledged as durable, and it could not be "
                                    "read again: ",
                                    frame.status().message())));
  return false;
}

void FrameUploader::Session::ReadResponses(Stream* stream) {
  v1::UploadFramesResponse response;
  while (stream->Read(&response)) {
    UploadProgress progress;
    std::optional<LostFrames> lost;
    std::vector<RefusedUpload> refused;
    {
      const absl::MutexLock lock(&mutex_);
      const auto known = static_cast<std::ptrdiff_t>(queue_.refused().size());
      const absl::Status status = Take(response, &lost);
      refused.assign(queue_.refused().begin() + known, queue_.refused().end());
      if (!status.ok()) FailStream(status);
      progress = queue_.progress();
      progress.reconnections = reconnections_;
    }
    if (options_.on_lost && lost) options_.on_lost(*lost);
    if (options_.on_refused) std::for_each(refused.begin(), refused.end(), options_.on_refused);
    if (options_.on_progress && response.has_ack()) options_.on_progress(progress);
  }
  const absl::MutexLock lock(&mutex_);
  stream_.ended = true;
}

absl::Status FrameUploader::Session::Take(const v1::UploadFramesResponse& response,
                                          std::optional<LostFrames>* lost) {
  switch (response.kind_case()) {
    case v1::UploadFramesResponse::kOpened: {
      absl::StatusOr<std::optional<LostFrames>> opened = queue_.Open(response.opened());
      stream_.opened = opened.ok();
      if (opened.ok()) *lost = *opened;
      return opened.status();
    }
    case v1::UploadFramesResponse::kAck:
      return queue_.Acknowledge(response.ack());
    case v1::UploadFramesResponse::kCredit:
      queue_.Grant(response.credit());
      return absl::OkStatus();
    case v1::UploadFramesResponse::KIND_NOT_SET:
      // A message kind of a newer server; not requested.
      return absl::OkStatus();
  }
  return absl::OkStatus();
}

// Called after the stream ended with OK. The acknowledgement of frames that an earlier, broken
// stream uploaded may be lost, so the session's state is requested from the server.
absl::Status FrameUploader::Session::ConfirmIntegration(
    const std::shared_ptr<grpc::ChannelInterface>& channel) {
  {
    const absl::MutexLock lock(&mutex_);
    if (finishing_ && queue_.all_integrated()) return absl::OkStatus();
    if (!finishing_ || !queue_.all_sent()) {
      return absl::UnavailableError("the server ended the upload before all frames were sent");
    }
  }
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + kConfirmationTimeout);
  v1::GetUploadStateRequest request;
  request.set_map(map_);
  request.set_robot(options_.robot);
  request.set_sensor(options_.sensor);
  request.set_session(options_.session);
  v1::UploadState state;
  const grpc::Status status =
      v1::IngestService::NewStub(channel)->GetUploadState(&context, request, &state);
  if (!status.ok()) return FromGrpcStatus(status);
  v1::UploadAck ack;
  ack.set_level(v1::ACK_LEVEL_INTEGRATED);
  ack.set_client_seq(state.integrated_client_seq());
  ack.set_revision(AskForRevision(channel));
  const absl::MutexLock lock(&mutex_);
  absl::Status taken = queue_.Acknowledge(ack);
  if (!taken.ok() || queue_.all_integrated()) return taken;
  return absl::UnavailableError("the server ended the upload before all frames were integrated");
}

// Returns the revision of the map after its integration was confirmed; 0 if this client lacks the
// permission to read it.
std::uint64_t FrameUploader::Session::AskForRevision(
    const std::shared_ptr<grpc::ChannelInterface>& channel) const {
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + kConfirmationTimeout);
  v1::GetMapRequest request;
  request.set_name(map_);
  request.mutable_read_mask()->add_paths("state.revision");
  v1::Map map;
  const grpc::Status status = v1::MapService::NewStub(channel)->GetMap(&context, request, &map);
  return status.ok() ? map.state().revision() : 0;
}

void FrameUploader::Session::FailStream(const absl::Status& error) {
  if (stream_.error.ok()) stream_.error = error;
  if (stream_.context != nullptr) stream_.context->TryCancel();
}

bool FrameUploader::Session::HasRoom() const {
  return done_ || finishing_ || queue_.buffered_bytes() < options_.max_buffered_bytes;
}

bool FrameUploader::Session::WriterHasWork() const {
  return stream_.ended || cancelled_ || queue_.CanTakeBatch() || queue_.FrameToReadAgain() ||
         (finishing_ && queue_.all_sent());
}

bool FrameUploader::Session::OpeningIsOver() const {
  return stream_.opened || stream_.ended || cancelled_;
}

}  // namespace steadymap
