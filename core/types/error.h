#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include <absl/status/status.h>

/// Errors of the wire protocol. An `absl::Status` carries the code and a readable message. Its
/// payloads carry the machine-readable part: a stable reason and the path of the offending field.
/// `proto/convert` maps them to `google.rpc.ErrorInfo` and `google.rpc.BadRequest`.
namespace steadymap {

/// The stable reasons of the service's errors. The spelling is part of the wire format.
namespace reason {
inline constexpr std::string_view kNonFinitePose = "NON_FINITE_POSE";
inline constexpr std::string_view kNotARotation = "NOT_A_ROTATION";
inline constexpr std::string_view kBadIntrinsics = "BAD_INTRINSICS";
inline constexpr std::string_view kImageSizeMismatch = "IMAGE_SIZE_MISMATCH";
inline constexpr std::string_view kBadDepthEncoding = "BAD_DEPTH_ENCODING";
inline constexpr std::string_view kBadImageEncoding = "BAD_IMAGE_ENCODING";
inline constexpr std::string_view kLabelOutOfRange = "LABEL_OUT_OF_RANGE";
inline constexpr std::string_view kBadPageToken = "BAD_PAGE_TOKEN";
inline constexpr std::string_view kBadResumeToken = "BAD_RESUME_TOKEN";
inline constexpr std::string_view kBadMessage = "BAD_MESSAGE";
inline constexpr std::string_view kBadName = "BAD_NAME";
inline constexpr std::string_view kBadTimestamp = "BAD_TIMESTAMP";
inline constexpr std::string_view kBadSequence = "BAD_SEQUENCE";
inline constexpr std::string_view kBadValue = "BAD_VALUE";
inline constexpr std::string_view kNotFound = "NOT_FOUND";
inline constexpr std::string_view kAlreadyExists = "ALREADY_EXISTS";
inline constexpr std::string_view kRevisionCompacted = "REVISION_COMPACTED";
inline constexpr std::string_view kRevisionInFuture = "REVISION_IN_FUTURE";
inline constexpr std::string_view kSlowConsumer = "SLOW_CONSUMER";
inline constexpr std::string_view kUploadSuperseded = "UPLOAD_SUPERSEDED";
inline constexpr std::string_view kEtagMismatch = "ETAG_MISMATCH";
inline constexpr std::string_view kBadCaptureTime = "BAD_CAPTURE_TIME";
inline constexpr std::string_view kFrameTooFine = "FRAME_TOO_FINE";
inline constexpr std::string_view kQueueFull = "QUEUE_FULL";
inline constexpr std::string_view kWorkLimit = "WORK_LIMIT";
inline constexpr std::string_view kRateLimit = "RATE_LIMIT";
inline constexpr std::string_view kMapBytes = "MAP_BYTES";
inline constexpr std::string_view kMemoryLow = "MEMORY_LOW";
inline constexpr std::string_view kDiskLow = "DISK_LOW";
inline constexpr std::string_view kMessageTooLarge = "MESSAGE_TOO_LARGE";
inline constexpr std::string_view kDraining = "DRAINING";
inline constexpr std::string_view kStoreReadOnly = "STORE_READ_ONLY";
inline constexpr std::string_view kMapOpening = "MAP_OPENING";
inline constexpr std::string_view kMapQuarantined = "MAP_QUARANTINED";
inline constexpr std::string_view kChecksum = "CHECKSUM";
inline constexpr std::string_view kAsOf = "AS_OF";
inline constexpr std::string_view kInternal = "INTERNAL";
}  // namespace reason

/// Makes a status with a reason. If one field is at fault, `field` is its path in the proto
/// spelling of the request, such as `frames[3].depth.data`.
absl::Status MakeError(absl::StatusCode code,
                       std::string_view reason,
                       std::string_view message,
                       std::string_view field = {});

/// Returns `MakeError(kInvalidArgument, ...)`.
absl::Status InvalidField(std::string_view reason,
                          std::string_view field,
                          std::string_view message);

/// Returns the reason of a status made by `MakeError`, empty for any other status.
std::string ReasonOf(const absl::Status& status);

/// Returns the field path of a status made by `MakeError`, empty if it has none.
std::string FieldOf(const absl::Status& status);

/// Adds a retry delay to an error: a retry is useful after `delay_ms` milliseconds, >= 0. Returns
/// OK unchanged.
absl::Status WithRetryDelay(absl::Status status, std::int64_t delay_ms);

/// Returns the retry delay set by `WithRetryDelay`, milliseconds; 0 if there is none.
std::int64_t RetryDelayMsOf(const absl::Status& status);

/// Prefixes the field path of `status` with `prefix` and a dot (no dot before `[`). Returns OK, and
/// a status without a field path, unchanged.
absl::Status WithFieldPrefix(const absl::Status& status, std::string_view prefix);

}  // namespace steadymap
