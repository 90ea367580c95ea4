#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "core/types/timestamp.h"
#include "server/store/model/store.h"

namespace steadymap::storage::v1 {
class MapRecord;
class PoseRecord;
class SemanticClass;
class SessionRecord;
}  // namespace steadymap::storage::v1

/// The values of the store: an envelope around each, and the payload.
///
/// Envelope: u8 schema version, u32 CRC-32C (little-endian) over column family name, a zero byte,
/// key, version and payload; then the payload. The checksum detects a flipped bit, and also an
/// intact value under a wrong key.
namespace steadymap {

/// Version of the records that this server writes. It reads this version and older ones. A store of
/// another folder schema (`folder_lock.h`) may contain other versions.
inline constexpr std::uint8_t kRecordVersion = 1;

/// The location of a value. The checksum of the value covers it, and errors contain it.
struct ValuePlace {
  std::string_view column_family;
  std::string_view key;
};

/// Returns the stored value for `payload`: the envelope, then the payload.
std::string Seal(const ValuePlace& place, std::string_view payload);

/// Verifies a value and returns its payload, which points into `value`. Errors: `DataLoss` with
/// reason `CHECKSUM` and the column family and key in the message; `FailedPrecondition` for a newer
/// version.
absl::StatusOr<std::string_view> Unseal(const ValuePlace& place, std::string_view value);

/// Returns `DataLoss` with reason `CHECKSUM`; `what` completes "the value of key ... in column
/// family ...".
absl::Status DamagedValue(const ValuePlace& place, std::string_view what);

/// Serialises and seals a protobuf message.
template <typename Proto>
std::string SealRecord(const ValuePlace& place, const Proto& record) {
  return Seal(place, record.SerializeAsString());
}

/// Verifies and parses a value made by `SealRecord`. Errors: as `Unseal`, and `DamagedValue` for a
/// payload that cannot be parsed.
template <typename Proto>
absl::Status UnsealRecord(const ValuePlace& place, std::string_view value, Proto* record) {
  const absl::StatusOr<std::string_view> payload = Unseal(place, value);
  if (!payload.ok()) return payload.status();
  if (!record->ParseFromArray(payload->data(), static_cast<int>(payload->size()))) {
    return DamagedValue(place, "is not a valid record");
  }
  return absl::OkStatus();
}

/// Converts records to protobuf and back. A round trip preserves every bit. `FromProto` returns
/// `DataLoss` for content that `ToProto` cannot have written.
storage::v1::MapRecord ToProto(const MapRecord& record);
absl::StatusOr<MapRecord> FromProto(const storage::v1::MapRecord& record);
storage::v1::SessionRecord ToProto(const SessionRecord& record);
absl::StatusOr<SessionRecord> FromProto(const storage::v1::SessionRecord& record);

storage::v1::PoseRecord ToProto(const FramePose& pose);
absl::StatusOr<FramePose> FromProto(MapSequence sequence, const storage::v1::PoseRecord& record);
storage::v1::SemanticClass ToProto(const SemanticClass& row);
absl::StatusOr<SemanticClass> FromProto(const storage::v1::SemanticClass& row);

}  // namespace steadymap
