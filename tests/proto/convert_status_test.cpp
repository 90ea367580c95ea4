#include "proto/convert_status.h"

#include <cstdint>
#include <string>
#include <tuple>
#include <vector>

#include <google/protobuf/descriptor.h>
#include <gtest/gtest.h>

#include "core/types/error.h"
#include "proto/grpc_status.h"

#include "steadymap/v1/ingest_service.pb.h"

namespace steadymap {
namespace {

/// Returns an error detail, packed in an Any under its type URL of google.rpc.
google::protobuf::Any Detail(const std::string& name, const google::protobuf::Message& message) {
  google::protobuf::Any detail;
  detail.set_type_url("type.googleapis.com/google.rpc." + name);
  detail.set_value(message.SerializeAsString());
  return detail;
}

/// Returns a length-delimited field on the wire. `bytes` must be short.
std::string Field(int number, const std::string& bytes) {
  return std::string{static_cast<char>(number << 3 | 2), static_cast<char>(bytes.size())} + bytes;
}

TEST(ConvertStatus, TheTrailerIsAStandardStatus) {
  const grpc::Status status = ToGrpcStatus(InvalidField("BAD_NAME", "map_id", "no good"));
  const std::string info = Field(1, "BAD_NAME") + Field(2, "steadymap");
  const std::string bad_request = Field(1, Field(1, "map_id") + Field(2, "no good"));
  EXPECT_EQ(
      status.error_details(),
      "\x08\x03" + Field(2, "no good") +
          Field(3, Field(1, "type.googleapis.com/google.rpc.ErrorInfo") + Field(2, info)) +
          Field(3, Field(1, "type.googleapis.com/google.rpc.BadRequest") + Field(2, bad_request)));
}

TEST(ConvertStatus, EveryDetailGoesByItsStandardName) {
  const v1::Status message =
      ToProto(MakeError(absl::StatusCode::kUnavailable, reason::kDraining, "text", "field"));
  std::vector<std::string> urls;
  for (const auto& detail : message.details()) urls.push_back(detail.type_url());
  EXPECT_EQ(urls,
            (std::vector<std::string>{"type.googleapis.com/google.rpc.ErrorInfo",
                                      "type.googleapis.com/google.rpc.BadRequest",
                                      "type.googleapis.com/google.rpc.RetryInfo"}));
}

TEST(ConvertStatus, DetailsOfOtherNamesAndBrokenOnesAreIgnored) {
  v1::ErrorInfo info;
  info.set_reason("BAD_NAME");
  info.set_domain("steadymap");
  const auto reason_of = [&](const std::string& type_url, const std::string& value) {
    v1::Status message;
    message.set_code(3);
    message.add_details()->set_type_url(type_url);
    message.mutable_details(0)->set_value(value);
    return ReasonOf(FromProto(message));
  };
  const std::string bytes = info.SerializeAsString();
  EXPECT_EQ(reason_of("type.googleapis.com/google.rpc.ErrorInfo", bytes), "BAD_NAME");
  EXPECT_EQ(reason_of("example.com/types/google.rpc.ErrorInfo", bytes), "BAD_NAME");
  EXPECT_EQ(reason_of("type.googleapis.com/steadymap.v1.ErrorInfo", bytes), "");
  EXPECT_EQ(reason_of("google.rpc.ErrorInfo", bytes), "");
  EXPECT_EQ(reason_of("", bytes), "");
  EXPECT_EQ(reason_of("type.googleapis.com/google.rpc.ErrorInfo", "\xff"), "");
}

// Another library in the process may register the original messages. Protobuf aborts a process that
// registers two files or messages under one name.
TEST(ConvertStatus, NothingIsRegisteredUnderNamesOfGoogleRpc) {
  const auto* const pool = google::protobuf::DescriptorPool::generated_pool();
  // Also links the upload messages, which contain a status, into this program.
  EXPECT_EQ(v1::RefusedFrame::descriptor()->FindFieldByName("status")->message_type(),
            v1::Status::descriptor());
  for (const char* name : {"Status", "ErrorInfo", "BadRequest", "RetryInfo"}) {
    EXPECT_NE(pool->FindMessageTypeByName(std::string("steadymap.v1.") + name), nullptr) << name;
    EXPECT_EQ(pool->FindMessageTypeByName(std::string("google.rpc.") + name), nullptr) << name;
  }
  EXPECT_EQ(pool->FindFileByName("google/rpc/status.proto"), nullptr);
  EXPECT_EQ(pool->FindFileByName("google/rpc/error_details.proto"), nullptr);
}

TEST(ConvertStatus, CodeMessageReasonAndFieldComeBack) {
  const absl::Status status = InvalidField("BAD_NAME", "frames[3].depth", "no good");
  const absl::Status back = FromGrpcStatus(ToGrpcStatus(status));
  EXPECT_EQ(back.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(back.message(), "no good");
  EXPECT_EQ(ReasonOf(back), "BAD_NAME");
  EXPECT_EQ(FieldOf(back), "frames[3].depth");
}

TEST(ConvertStatus, EveryCodeComesBack) {
  for (int code = 0; code <= 16; ++code) {
    const absl::Status status = MakeError(static_cast<absl::StatusCode>(code), "REASON", "text");
    EXPECT_EQ(FromGrpcStatus(ToGrpcStatus(status)).code(), status.code());
  }
}

TEST(ConvertStatus, WhatMayPassByWaitingSaysHowLong) {
  const auto retries = [](std::string_view reason) {
    const v1::Status message =
        ToProto(MakeError(absl::StatusCode::kResourceExhausted, reason, "text"));
    int count = 0;
    for (const auto& detail : message.details()) {
      count += detail.type_url() == "type.googleapis.com/google.rpc.RetryInfo";
    }
    return count;
  };
  for (const auto reason :
       {reason::kQueueFull, reason::kDiskLow, reason::kDraining, reason::kStoreReadOnly}) {
    EXPECT_EQ(retries(reason), 1) << reason;
  }
  for (const auto reason : {reason::kMessageTooLarge, reason::kMapBytes, reason::kBadValue}) {
    EXPECT_EQ(retries(reason), 0) << reason;
  }
}

TEST(ConvertStatus, TheDelayUntilAnotherTryComesBack) {
  const auto delay_of = [](std::string_view reason) {
    return RetryDelayMsOf(
        FromProto(ToProto(MakeError(absl::StatusCode::kResourceExhausted, reason, "text"))));
  };
  EXPECT_EQ(delay_of(reason::kQueueFull), 1'000);
  EXPECT_EQ(delay_of(reason::kDiskLow), 30'000);
  EXPECT_EQ(delay_of(reason::kMessageTooLarge), 0);
  const absl::Status low =
      MakeError(absl::StatusCode::kResourceExhausted, reason::kDiskLow, "text");
  EXPECT_EQ(RetryDelayMsOf(FromProto(ToProto(WithRetryDelay(low, 2'500)))), 2'500)
      << "whoever made the status knows better";
}

TEST(ConvertStatus, ADelayThatMakesNoSenseIsCut) {
  for (const auto& [seconds, nanos, expected_ms] :
       std::vector<std::tuple<std::int64_t, int, std::int64_t>>{
           {1, 500'000'000, 1'500}, {-5, 0, 0}, {1'000'000'000'000, 0, 600'000}, {0, -7, 0}}) {
    v1::Status message =
        ToProto(MakeError(absl::StatusCode::kUnavailable, reason::kChecksum, "text"));
    v1::RetryInfo info;
    info.mutable_retry_delay()->set_seconds(seconds);
    info.mutable_retry_delay()->set_nanos(nanos);
    *message.add_details() = Detail("RetryInfo", info);
    EXPECT_EQ(RetryDelayMsOf(FromProto(message)), expected_ms) << seconds;
  }
}

TEST(ConvertStatus, MessageThatQuotesGarbageStaysReadable) {
  const std::string garbage = "got \"\xff\xc3(\x01\n" + std::string(100'000, 'x') + "\"";
  const grpc::Status status = ToGrpcStatus(InvalidField("BAD_NAME", "name", garbage));
  EXPECT_LT(status.error_details().size() + status.error_message().size(), 8192U * 3 / 4);
  const absl::Status back = FromGrpcStatus(status);
  EXPECT_EQ(ReasonOf(back), "BAD_NAME");
  EXPECT_TRUE(back.message().substr(0, 7) == "got \"??");
}

TEST(ConvertStatus, StatusOfAnotherServerKeepsCodeAndMessage) {
  const absl::Status back =
      FromGrpcStatus(grpc::Status(grpc::StatusCode::UNAVAILABLE, "no route", "not a message"));
  EXPECT_EQ(back.code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(back.message(), "no route");
  EXPECT_EQ(ReasonOf(back), "");
}

TEST(ConvertStatus, ReasonOfAnotherDomainIsIgnored) {
  v1::Status message;
  message.set_code(5);
  v1::ErrorInfo info;
  info.set_reason("QUOTA");
  info.set_domain("example.com");
  *message.add_details() = Detail("ErrorInfo", info);
  EXPECT_EQ(ReasonOf(FromProto(message)), "");
  EXPECT_EQ(FromProto(message).code(), absl::StatusCode::kNotFound);
}

TEST(ConvertStatus, CodeThatIsNoneIsUnknown) {
  v1::Status message;
  for (const int code : {-1, 17, 1 << 30}) {
    message.set_code(code);
    EXPECT_EQ(FromProto(message).code(), absl::StatusCode::kUnknown);
  }
}

}  // namespace
}  // namespace steadymap
