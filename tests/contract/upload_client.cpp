#include "tests/contract/upload_client.h"

namespace steadymap {

v1::FrameBatch MakeBatch(std::uint64_t first_client_seq, int count) {
  v1::FrameBatch batch;
  batch.set_first_client_seq(first_client_seq);
  for (int i = 0; i < count; ++i) {
    WallFrame wall;
    const auto sequence = static_cast<double>(first_client_seq) + i;
    wall.eye_world.y() = 0.01 * sequence;
    wall.capture_time_s = 100.0 + sequence;
    *batch.add_frames() = MakeWallFrame(wall);
  }
  return batch;
}

UploadClient::UploadClient(TestService* service) {
  SetDeadline(&context_);
  stream_ = service->ingest().UploadFrames(&context_);
}

UploadClient::~UploadClient() {
  if (finished_) return;
  context_.TryCancel();
  Finish().IgnoreError();
}

absl::StatusOr<v1::UploadOpened> UploadClient::Open(const UploadSession& session,
                                                    const std::vector<v1::AckLevel>& levels) {
  v1::UploadFramesRequest request;
  request.mutable_open()->set_map(session.map);
  request.mutable_open()->set_robot(session.robot);
  request.mutable_open()->set_session(session.session);
  for (const v1::AckLevel level : levels) request.mutable_open()->add_ack_levels(level);
  Send(request);
  const std::optional<v1::UploadFramesResponse> response = Read();
  if (!response) return Finish();
  return response->opened();
}

bool UploadClient::Send(const v1::UploadFramesRequest& request) { return stream_->Write(request); }

bool UploadClient::Send(const v1::FrameBatch& batch) {
  v1::UploadFramesRequest request;
  *request.mutable_batch() = batch;
  return Send(request);
}

std::optional<v1::UploadFramesResponse> UploadClient::Read() {
  v1::UploadFramesResponse response;
  if (!stream_->Read(&response)) return std::nullopt;
  if (response.has_ack()) {
    acks_[static_cast<std::size_t>(response.ack().level())] = response.ack();
    for (const v1::RefusedFrame& refused : response.ack().refused()) refused_.push_back(refused);
  }
  if (response.has_credit()) {
    credit_.set_frames(credit_.frames() + response.credit().frames());
    credit_.set_bytes(credit_.bytes() + response.credit().bytes());
  }
  return response;
}

std::optional<v1::UploadAck> UploadClient::ReadUntil(v1::AckLevel level, std::uint64_t client_seq) {
  while (newest(level).client_seq() < client_seq) {
    if (!Read()) return std::nullopt;
  }
  return newest(level);
}

void UploadClient::HalfClose() { stream_->WritesDone(); }

void UploadClient::Cancel() { context_.TryCancel(); }

absl::Status UploadClient::Finish() {
  while (Read()) continue;
  finished_ = true;
  return FromGrpcStatus(stream_->Finish());
}

absl::Status UploadClient::Close() {
  HalfClose();
  return Finish();
}

absl::Status UploadAndClose(TestService* service,
                            const UploadSession& session,
                            const v1::FrameBatch& batch) {
  UploadClient client(service);
  if (absl::Status status = client.Open(session).status(); !status.ok()) return status;
  client.Send(batch);
  return client.Close();
}

absl::StatusOr<v1::UploadAck> UploadByCall(TestService* service,
                                           const UploadSession& session,
                                           const v1::FrameBatch& batch,
                                           v1::AckLevel wait_for) {
  v1::UploadFrameBatchRequest request;
  request.set_map(session.map);
  request.set_robot(session.robot);
  request.set_session(session.session);
  *request.mutable_batch() = batch;
  request.set_wait_for(wait_for);
  v1::UploadFrameBatchResponse response;
  absl::Status status = Call([&](auto* context) {
    return service->ingest().UploadFrameBatch(context, request, &response);
  });
  if (!status.ok()) return status;
  return response.ack();
}

}  // namespace steadymap
