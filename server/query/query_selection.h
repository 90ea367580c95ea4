#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <google/protobuf/repeated_field.h>

#include "core/geometry/geometry.h"
#include "core/map/map_snapshot.h"
#include "core/map/placed_volume.h"
#include "core/types/identifiers.h"

#include "steadymap/v1/geometry.pb.h"
#include "steadymap/v1/query_service.pb.h"

namespace steadymap {

/// The object that a request names, and the fields that say so.
struct ObjectName {
  std::string map;  ///< `tenants/{tenant}/maps/{map}`, unchecked.
  ObjectId object;
  std::string map_field = "map";
  std::string object_field = "object_id";
};

/// Reads `name`, or `map` and `object_id`. Errors: `InvalidArgument` with the field `name` for both
/// together (`BAD_VALUE`) and for what is no name of an object (`BAD_NAME`).
absl::StatusOr<ObjectName> ReadObjectName(const v1::GetObjectRequest& request);

/// That reads of the past are not possible yet: `Unimplemented`, reason `AS_OF`, field `as_of`.
absl::Status AsOfError();

/// The part of a map that a request asks for; none for all of it. `message` is null where the
/// request has no box. Errors: as for `v1::Box`, below the field `box`.
absl::StatusOr<std::optional<Box>> ReadBox(const v1::Box* message);

/// The volumes that a request names, the background first, then objects by rising id, each once;
/// what the map shows if it names none. Errors: `NotFound` with the field `object_ids[i]`.
absl::StatusOr<std::vector<PlacedVolume>> SelectVolumes(
    const MapSnapshot& snapshot, const google::protobuf::RepeatedField<std::uint64_t>& object_ids);

/// The classes of a filter. Errors: `InvalidArgument` with the field `class_ids` for more than
/// 1000, with `class_ids[i]` for one that no map can have.
absl::StatusOr<std::set<ClassId>> ReadClassFilter(
    const google::protobuf::RepeatedField<std::uint32_t>& class_ids);

/// OK if a filter names no more than 1000 values. Errors: `InvalidArgument` with the field.
absl::Status CheckFilterSize(std::string_view field, int size);

}  // namespace steadymap
