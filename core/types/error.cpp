#include "core/types/error.h"

#include <charconv>

#include <absl/strings/cord.h>

#include "core/types/absl_text.h"

namespace steadymap {
namespace {

constexpr char kReasonUrl[] = "steadymap/reason";
constexpr char kFieldUrl[] = "steadymap/field";
constexpr char kRetryDelayUrl[] = "steadymap/retry_delay_ms";

std::string PayloadOf(const absl::Status& status, const char* url) {
  const absl::optional<absl::Cord> payload = status.GetPayload(url);
  return payload ? std::string(*payload) : std::string();
}

}  // namespace

absl::Status MakeError(absl::StatusCode code,
                       std::string_view reason,
                       std::string_view message,
                       std::string_view field) {
  absl::Status status(code, Absl(message));
  status.SetPayload(kReasonUrl, absl::Cord(Absl(reason)));
  if (!field.empty()) status.SetPayload(kFieldUrl, absl::Cord(Absl(field)));
  return status;
}

absl::Status InvalidField(std::string_view reason,
                          std::string_view field,
                          std::string_view message) {
  return MakeError(absl::StatusCode::kInvalidArgument, reason, message, field);
}

std::string ReasonOf(const absl::Status& status) { return PayloadOf(status, kReasonUrl); }

std::string FieldOf(const absl::Status& status) { return PayloadOf(status, kFieldUrl); }

absl::Status WithRetryDelay(absl::Status status, std::int64_t delay_ms) {
  status.SetPayload(kRetryDelayUrl, absl::Cord(std::to_string(delay_ms)));
  return status;
}

std::int64_t RetryDelayMsOf(const absl::Status& status) {
  const std::string text = PayloadOf(status, kRetryDelayUrl);
  std::int64_t delay_ms = 0;
  std::from_chars(text.data(), text.data() + text.size(), delay_ms);
  return delay_ms;
}

absl::Status WithFieldPrefix(const absl::Status& status, std::string_view prefix) {
  const std::string field = FieldOf(status);
  if (status.ok() || field.empty()) return status;
  absl::Status prefixed = status;
  std::string path(prefix);
  if (field.front() != '[') path += '.';
  prefixed.SetPayload(kFieldUrl, absl::Cord(path + field));
  return prefixed;
}

}  // namespace steadymap
