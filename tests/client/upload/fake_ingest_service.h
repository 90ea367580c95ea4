#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "proto/batch_checksum.h"

#include "steadymap/v1/ingest_service.grpc.pb.h"

namespace steadymap {

/// The server's end of one upload stream, for a script.
class ScriptedStream {
 public:
  using Stream = grpc::ServerReaderWriter<v1::UploadFramesResponse, v1::UploadFramesRequest>;

  explicit ScriptedStream(Stream* stream) : stream_(stream) {}

  v1::UploadOpen ReadOpen() {
    v1::UploadFramesRequest request;
    EXPECT_TRUE(stream_->Read(&request));
    EXPECT_TRUE(request.has_open());
    return request.open();
  }

  /// Answers the opening; frames beyond this credit fail the test.
  void SendOpened(std::uint64_t resume_client_seq,
                  std::uint64_t credit_frames,
                  std::uint64_t credit_bytes = std::uint64_t{1} << 30,
                  std::uint64_t max_message_bytes = std::uint64_t{8} << 20) {
    v1::UploadFramesResponse response;
    v1::UploadOpened& opened = *response.mutable_opened();
    opened.set_resume_client_seq(resume_client_seq);
    opened.mutable_credit()->set_frames(credit_frames);
    opened.mutable_credit()->set_bytes(credit_bytes);
    opened.set_max_message_bytes(max_message_bytes);
    max_message_bytes_ = max_message_bytes;
    frames_left_ = credit_frames;
    bytes_left_ = credit_bytes;
    stream_->Write(response);
  }

  void SendCredit(std::uint64_t frames, std::uint64_t bytes) {
    frames_left_ += frames;
    bytes_left_ += bytes;
    v1::UploadFramesResponse response;
    response.mutable_credit()->set_frames(frames);
    response.mutable_credit()->set_bytes(bytes);
    stream_->Write(response);
  }

  void SendAck(v1::AckLevel level,
               std::uint64_t client_seq,
               const std::vector<v1::RefusedFrame>& refused = {}) {
    v1::UploadFramesResponse response;
    v1::UploadAck& ack = *response.mutable_ack();
    ack.set_level(level);
    ack.set_client_seq(client_seq);
    ack.set_map_seq(client_seq);
    if (level == v1::ACK_LEVEL_INTEGRATED) ack.set_revision(client_seq);
    for (const v1::RefusedFrame& frame : refused) *ack.add_refused() = frame;
    stream_->Write(response);
  }

  /// Reads the next batch and checks it against credit, limits and checksum; false at the client's
  /// end.
  bool ReadBatch(v1::FrameBatch* batch) {
    v1::UploadFramesRequest request;
    if (!stream_->Read(&request)) return false;
    EXPECT_TRUE(request.has_batch());
    EXPECT_LE(request.ByteSizeLong(), max_message_bytes_);
    *batch = request.batch();
    EXPECT_GE(batch->frames_size(), 1);
    EXPECT_EQ(batch->images_crc32c(), ImagesCrc32c(*batch));
    EXPECT_LE(batch->ByteSizeLong(), bytes_left_) << "credit in bytes overrun";
    EXPECT_LE(static_cast<std::uint64_t>(batch->frames_size()), frames_left_)
        << "credit in frames overrun";
    bytes_left_ -= batch->ByteSizeLong();
    frames_left_ -= static_cast<std::uint64_t>(batch->frames_size());
    for (int i = 0; i < batch->frames_size(); ++i) {
      received_.push_back(batch->first_client_seq() + static_cast<std::uint64_t>(i));
    }
    return true;
  }

  /// Reads batches until `client_seq` has arrived or the client ends; returns true if it arrived.
  bool ReadUntil(std::uint64_t client_seq) {
    v1::FrameBatch batch;
    while (received_.empty() || received_.back() < client_seq) {
      if (!ReadBatch(&batch)) return false;
    }
    return true;
  }

  /// Acts as a server that accepts everything: durable at once, integrated at the client's end.
  grpc::Status AcceptRest() {
    v1::FrameBatch batch;
    while (ReadBatch(&batch)) {
      SendAck(v1::ACK_LEVEL_DURABLE, received_.back());
      SendCredit(static_cast<std::uint64_t>(batch.frames_size()), batch.ByteSizeLong());
    }
    if (!received_.empty()) SendAck(v1::ACK_LEVEL_INTEGRATED, received_.back());
    return grpc::Status::OK;
  }

  /// Client sequences in the order of arrival.
  const std::vector<std::uint64_t>& received() const { return received_; }

 private:
  Stream* stream_;
  std::uint64_t max_message_bytes_ = 0;
  std::uint64_t frames_left_ = 0;
  std::uint64_t bytes_left_ = 0;
  std::vector<std::uint64_t> received_;
};

/// Plays one script per stream, in order, and refuses further streams.
class FakeIngestService final : public v1::IngestService::Service {
 public:
  using Script = std::function<grpc::Status(ScriptedStream&)>;

  explicit FakeIngestService(std::vector<Script> scripts)
      : scripts_(scripts.begin(), scripts.end()) {}

  /// Replaces the scripts; call before the first stream.
  void SetScripts(std::vector<Script> scripts) { scripts_.assign(scripts.begin(), scripts.end()); }

  /// Response of GetUploadState.
  v1::UploadState state;

  std::size_t streams_opened() const { return streams_opened_; }

  grpc::Status UploadFrames(grpc::ServerContext*, ScriptedStream::Stream* stream) override {
    ++streams_opened_;
    if (scripts_.empty()) return {grpc::StatusCode::FAILED_PRECONDITION, "no script is left"};
    const Script script = scripts_.front();
    scripts_.pop_front();
    ScriptedStream scripted(stream);
    return script(scripted);
  }

  grpc::Status GetUploadState(grpc::ServerContext*,
                              const v1::GetUploadStateRequest*,
                              v1::UploadState* answer) override {
    *answer = state;
    return grpc::Status::OK;
  }

 private:
  std::deque<Script> scripts_;  // Unguarded: the uploader has one stream at a time.
  std::atomic<std::size_t> streams_opened_ = 0;
};

}  // namespace steadymap
