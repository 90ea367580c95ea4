#include "proto/convert_status.h"

#include <cstdint>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "core/error.h"
#include "proto/grpc_status.h"

#include "google/rpc/error_details.pb.h"

namespace steadymap {
namespace {

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
    const google::rpc::Status message =
        ToProto(MakeError(absl::StatusCode::kResourceExhausted, reason, "text"));
    int count = 0;
    for (const auto& detail : message.details()) count += detail.Is<google::rpc::RetryInfo>();
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
}

TEST(ConvertStatus, ADelayThatMakesNoSenseIsCut) {
  for (const auto& [seconds, nanos, expected_ms] :
       std::vector<std::tuple<std::int64_t, int, std::int64_t>>{
           {1, 500'000'000, 1'500}, {-5, 0, 0}, {1'000'000'000'000, 0, 600'000}, {0, -7, 0}}) {
    google::rpc::Status message =
        ToProto(MakeError(absl::StatusCode::kUnavailable, reason::kChecksum, "text"));
    google::rpc::RetryInfo info;
    info.mutable_retry_delay()->set_seconds(seconds);
    info.mutable_retry_delay()->set_nanos(nanos);
    message.add_details()->PackFrom(info);
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
  google::rpc::Status message;
  message.set_code(5);
  google::rpc::ErrorInfo info;
  info.set_reason("QUOTA");
  info.set_domain("example.com");
  message.add_details()->PackFrom(info);
  EXPECT_EQ(ReasonOf(FromProto(message)), "");
  EXPECT_EQ(FromProto(message).code(), absl::StatusCode::kNotFound);
}

TEST(ConvertStatus, CodeThatIsNoneIsUnknown) {
  google::rpc::Status message;
  for (const int code : {-1, 17, 1 << 30}) {
    message.set_code(code);
    EXPECT_EQ(FromProto(message).code(), absl::StatusCode::kUnknown);
  }
}

}  // namespace
}  // namespace steadymap
