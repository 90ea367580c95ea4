#pragma once

#include <absl/status/statusor.h>

#include "core/map/map_delta.h"
#include "core/map/map_object.h"
#include "core/map/object_event.h"

namespace steadymap::storage::v1 {
class EventRecord;
class FreeBlockRecord;
class ObjectState;
}  // namespace steadymap::storage::v1

/// Converts the stored records of objects to protobuf and back. A round trip preserves every bit.
/// `FromProto` returns `DataLoss` for content that `ToProto` cannot have written.
namespace steadymap {

storage::v1::ObjectState ToProto(const ObjectState& state);
absl::StatusOr<ObjectState> FromProto(ObjectId id, const storage::v1::ObjectState& state);

storage::v1::EventRecord ToProto(const ObjectEvent& event);
absl::StatusOr<ObjectEvent> FromProto(const storage::v1::EventRecord& record);

storage::v1::FreeBlockRecord ToProto(const FreeBlock& block);
absl::StatusOr<FreeBlock> FromProto(const storage::v1::FreeBlockRecord& record);

}  // namespace steadymap
