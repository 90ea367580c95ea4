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

/// The values of the store: an envelope around each, and what stands inside.
///
/// Envelope: u8 schema version, u32 CRC-32C (little-endian) over column family name, a zero byte,
/// key, version and payload; then the payload. So a flipped bit is found, and so is a good value
/// under a wrong key.
namespace steadymap {

/// Version of the records that this server writes; it reads this one and older ones. A store of
/// another schema (`folder_lock.h`) may have others.
inline constexpr std::uint8_t kRecordVersion = 1;

/// Where a value stands: what its checksum covers besides itself, and what an error names.
struct ValuePlace {
  std::string_view column_family;
  std::string_view key;
};

/// The value for `payload`: the envelope, then the payload.
std::string Seal(const ValuePlace& place, std::string_view payload);

/// The payload, which points into `value`.
/// Errors: `DataLoss` with reason `CHECKSUM`, naming column family and key; `FailedPrecondition`
/// for a newer version.
absl::StatusOr<std::string_view> Unseal(const ValuePlace& place, std::string_view value);

/// `DataLoss` with reason `CHECKSUM`; `what` completes "the value of ... in ...".
absl::Status DamagedValue(const ValuePlace& place, std::string_view what);

/// A protobuf message, sealed.
template <typename Proto>
std::string SealRecord(const ValuePlace& place, const Proto& record) {
  return Seal(place, record.SerializeAsString());
}

/// The message in a value made by `SealRecord`. Errors: as `Unseal`.
template <typename Proto>
absl::Status UnsealRecord(const ValuePlace& place, std::string_view value, Proto* record) {
  const absl::StatusOr<std::string_view> payload = Unseal(place, value);
  if (!payload.ok()) return payload.status();
  if (!record->ParseFromArray(payload->data(), static_cast<int>(payload->size()))) {
    return DamagedValue(place, "is no record");
  }
  return absl::OkStatus();
}

/// Records to protobuf and back. Reading back gives bit for bit what was written.
/// Errors of the latter: `DataLoss` for what the former cannot have written.
storage::v1::MapRecord ToProto(const MapRecord& record);
absl::StatusOr<MapRecord> FromProto(const storage::v1::MapRecord& record);
storage::v1::SessionRecord ToProto(const SessionRecord& record);
absl::StatusOr<SessionRecord> FromProto(const storage::v1::SessionRecord& record);

storage::v1::PoseRecord ToProto(const FramePose& pose);
absl::StatusOr<FramePose> FromProto(MapSequence sequence, const storage::v1::PoseRecord& record);
storage::v1::SemanticClass ToProto(const SemanticClass& row);
absl::StatusOr<SemanticClass> FromProto(const storage::v1::SemanticClass& row);

}  // namespace steadymap
