#include "proto/convert_status.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "core/types/error.h"

namespace steadymap {
namespace {

constexpr char kDomain[] = "steadymap";
constexpr std::string_view kTypeUrlPrefix = "type.googleapis.com/";

// Standard names of the details on the wire; status.proto gives their messages other names.
constexpr std::string_view kErrorInfo = "google.rpc.ErrorInfo";
constexpr std::string_view kBadRequest = "google.rpc.BadRequest";
constexpr std::string_view kRetryInfo = "google.rpc.RetryInfo";

constexpr int kMaxCode = static_cast<int>(absl::StatusCode::kUnauthenticated);

/// Default delay of the next attempt after an error with this reason.
struct RetryDelay {
  std::string_view reason;
  std::int64_t seconds;
};

// A queue empties in about a second, a restart takes a few seconds, and a full or failed disk needs
// an operator. MESSAGE_TOO_LARGE and MAP_BYTES have no entry: waiting does not help.
constexpr std::array kRetryDelays = {RetryDelay{reason::kQueueFull, 1},
                                     RetryDelay{reason::kRateLimit, 1},
                                     RetryDelay{reason::kDraining, 2},
                                     RetryDelay{reason::kDiskLow, 30},
                                     RetryDelay{reason::kStoreReadOnly, 30}};

// The trailers contain the message three times, and gRPC limits them to 8 KiB by default.
constexpr std::size_t kMaxMessageBytes = 1000;

constexpr std::int64_t kMaxRetryDelayS = 600;

/// The message of a status in a form that is safe in a trailer: short printable ASCII. A message
/// may quote a request, and a cut inside a multi-byte character would make the details unreadable.
std::string TrailerText(const absl::Status& status) {
  std::string text(status.message().substr(0, kMaxMessageBytes));
  for (char& character : text) {
    if (character < ' ' || character > '~') character = '?';
  }
  return text;
}

void AddDetail(std::string_view name,
               const google::protobuf::Message& detail,
               v1::Status* message) {
  google::protobuf::Any* any = message->add_details();
  any->set_type_url(std::string(kTypeUrlPrefix) + std::string(name));
  any->set_value(detail.SerializeAsString());
}

/// Reads `any` into `detail`; true if its type URL ends with `name` and it parses. The part of the
/// URL before the last slash is ignored.
bool ReadDetail(const google::protobuf::Any& any,
                std::string_view name,
                google::protobuf::Message* detail) {
  const std::string_view url = any.type_url();
  const std::size_t slash = url.rfind('/');
  return slash != url.npos && url.substr(slash + 1) == name && detail->ParseFromString(any.value());
}

/// Adds the delay of the next attempt: that of the status, or else the default of its reason.
void AddRetryInfo(const absl::Status& status, v1::Status* message) {
  constexpr std::int64_t kMsPerSecond = 1000;
  std::int64_t delay_ms = RetryDelayMsOf(status);
  for (const RetryDelay& delay : kRetryDelays) {
    if (delay_ms == 0 && delay.reason == ReasonOf(status)) delay_ms = kMsPerSecond * delay.seconds;
  }
  if (delay_ms == 0) return;
  v1::RetryInfo info;
  info.mutable_retry_delay()->set_seconds(delay_ms / kMsPerSecond);
  info.mutable_retry_delay()->set_nanos(static_cast<std::int32_t>(delay_ms % kMsPerSecond) *
                                        1'000'000);
  AddDetail(kRetryInfo, info, message);
}

/// The delay that a server requests, milliseconds, limited to [0, 10 min].
std::int64_t ReadDelayMs(const google::protobuf::Duration& delay) {
  const std::int64_t seconds = std::clamp(delay.seconds(), std::int64_t{0}, kMaxRetryDelayS);
  const std::int64_t ms = 1000 * seconds + delay.nanos() / 1'000'000;
  return std::clamp(ms, std::int64_t{0}, 1000 * kMaxRetryDelayS);
}

}  // namespace

v1::Status ToProto(const absl::Status& status) {
  v1::Status message;
  message.set_code(static_cast<int>(status.code()));
  message.set_message(TrailerText(status));
  const std::string reason = ReasonOf(status);
  if (reason.empty()) return message;
  v1::ErrorInfo info;
  info.set_reason(reason);
  info.set_domain(kDomain);
  AddDetail(kErrorInfo, info, &message);
  if (const std::string field = FieldOf(status); !field.empty()) {
    v1::BadRequest bad_request;
    v1::BadRequest::FieldViolation* violation = bad_request.add_field_violations();
    violation->set_field(field);
    violation->set_description(message.message());
    AddDetail(kBadRequest, bad_request, &message);
  }
  AddRetryInfo(status, &message);
  return message;
}

absl::Status FromProto(const v1::Status& message) {
  if (message.code() == 0) return absl::OkStatus();
  const bool known = message.code() > 0 && message.code() <= kMaxCode;
  const absl::StatusCode code =
      known ? static_cast<absl::StatusCode>(message.code()) : absl::StatusCode::kUnknown;
  std::string reason;
  std::string field;
  std::int64_t retry_delay_ms = 0;
  for (const google::protobuf::Any& detail : message.details()) {
    v1::ErrorInfo info;
    v1::BadRequest bad_request;
    v1::RetryInfo retry;
    if (ReadDetail(detail, kErrorInfo, &info)) {
      if (info.domain() == kDomain) reason = info.reason();
    } else if (ReadDetail(detail, kBadRequest, &bad_request) &&
               bad_request.field_violations_size() > 0) {
      field = bad_request.field_violations(0).field();
    } else if (ReadDetail(detail, kRetryInfo, &retry)) {
      retry_delay_ms = ReadDelayMs(retry.retry_delay());
    }
  }
  if (reason.empty()) return {code, message.message()};
  absl::Status status = MakeError(code, reason, message.message(), field);
  return retry_delay_ms > 0 ? WithRetryDelay(std::move(status), retry_delay_ms) : status;
}

}  // namespace steadymap
