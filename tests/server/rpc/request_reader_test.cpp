#include "server/rpc/request_reader.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/types/error.h"

#include "steadymap/v1/ingest_service.pb.h"

namespace steadymap {
namespace {

constexpr RequestLimits kLimits{.max_bytes = 1 << 20, .max_fields = 1000};

grpc::ByteBuffer BytesOf(const std::string& text) {
  const grpc::Slice slice(text);
  return grpc::ByteBuffer(&slice, 1);
}

/// Returns a buffer in slices of a few bytes, like those of a slow network.
grpc::ByteBuffer InPieces(const std::string& text) {
  std::vector<grpc::Slice> slices;
  for (std::size_t at = 0; at < text.size(); at += 7) slices.emplace_back(text.substr(at, 7));
  return grpc::ByteBuffer(slices.data(), slices.size());
}

v1::UploadFramesRequest BatchOf(int frames) {
  v1::UploadFramesRequest request;
  request.mutable_batch()->set_first_client_seq(300);
  for (int i = 0; i < frames; ++i) {
    v1::Frame* frame = request.mutable_batch()->add_frames();
    frame->mutable_capture_time()->set_seconds(i + 1);
    frame->mutable_depth()->set_data(std::string(100, '\0'));
  }
  return request;
}

TEST(ReadRequest, ReadsWhatWasWrittenHoweverItComes) {
  const v1::UploadFramesRequest written = BatchOf(20);
  for (const grpc::ByteBuffer& bytes :
       {ToByteBuffer(written), InPieces(written.SerializeAsString())}) {
    v1::UploadFramesRequest read;
    ASSERT_TRUE(ReadRequest(bytes, kLimits, &read).ok());
    EXPECT_EQ(read.SerializeAsString(), written.SerializeAsString());
  }
  v1::UploadFramesRequest nothing;
  EXPECT_TRUE(ReadRequest(grpc::ByteBuffer(), kLimits, &nothing).ok());
}

TEST(ReadRequest, CountsFieldsOfNestedMessages) {
  const grpc::ByteBuffer bytes = ToByteBuffer(BatchOf(10));
  // `batch`, its sequence, and for each frame the frame itself, two messages and a field in each.
  constexpr std::size_t kFields = 2 + 10 * 5;
  v1::UploadFramesRequest read;
  EXPECT_TRUE(ReadRequest(bytes, {1 << 20, kFields}, &read).ok());
  const absl::Status status = ReadRequest(bytes, {1 << 20, kFields - 1}, &read);
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(ReasonOf(status), reason::kMessageTooLarge);
}

TEST(ReadRequest, RefusesAMillionEmptyFramesBeforeItMakesOne) {
  std::string frames;
  for (int i = 0; i < 100'000; ++i) frames += std::string("\x12\x00", 2);
  v1::FrameBatch batch;
  const absl::Status status = ReadRequest(BytesOf(frames), kLimits, &batch);
  EXPECT_EQ(ReasonOf(status), reason::kMessageTooLarge);
  EXPECT_EQ(batch.frames_size(), 0);
}

TEST(ReadRequest, RefusesTooManyBytes) {
  const grpc::ByteBuffer bytes = ToByteBuffer(BatchOf(10));
  v1::UploadFramesRequest read;
  EXPECT_TRUE(ReadRequest(bytes, {bytes.Length(), 1000}, &read).ok());
  EXPECT_EQ(ReasonOf(ReadRequest(bytes, {bytes.Length() - 1, 1000}, &read)),
            reason::kMessageTooLarge);
}

TEST(ReadRequest, DropsFieldsThatItDoesNotKnow) {
  v1::FrameBatch batch;
  batch.set_first_client_seq(7);
  const std::string known = batch.SerializeAsString();
  v1::FrameBatch with_frame = batch;
  with_frame.add_frames();

  struct Case {
    std::string bytes;
    std::string read;
  };

  for (const Case& each :
       {// Field 1000: 3, and a string of field 1001.
        Case{known + std::string("\xC0\x3E\x03\xCA\x3E\x02hi", 8), known},
        // The sequence as a string.
        Case{known + std::string("\x0A\x02hi", 4), known},
        // A frame with field 1000.
        Case{known + std::string("\x12\x03\xC0\x3E\x03", 5), with_frame.SerializeAsString()}}) {
    v1::FrameBatch read;
    ASSERT_TRUE(ReadRequest(BytesOf(each.bytes), kLimits, &read).ok());
    EXPECT_EQ(read.SerializeAsString(), each.read);
  }
}

TEST(ReadRequest, RefusesGarbage) {
  const std::string whole = BatchOf(2).SerializeAsString();
  for (const std::string& bytes : {std::string("\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xFF"),
                                   std::string("\x0B"),  // A group that never ends.
                                   std::string("\x12\x05"
                                               "abc"),  // Shorter than its length field.
                                   whole.substr(0, whole.size() - 1)}) {
    v1::UploadFramesRequest read;
    const absl::Status status = ReadRequest(BytesOf(bytes), kLimits, &read);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_EQ(ReasonOf(status), reason::kBadMessage);
  }
}

}  // namespace
}  // namespace steadymap
