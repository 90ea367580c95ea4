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

/// The object that a request names, and the fields that contain the name.
struct ObjectName {
  std::string map;  ///< `tenants/{tenant}/maps/{map}`, not checked.
  ObjectId object;
  std::string map_field = "map";
  std::string object_field = "object_id";
};

/// Reads `name`, or `map` and `object_id`. Errors: `InvalidArgument` with the field `name`, with
/// reason `BAD_VALUE` if both are set, and `BAD_NAME` for an invalid name of an object.
absl::StatusOr<ObjectName> ReadObjectName(const v1::GetObjectRequest& request);

/// Returns the error for reads of past revisions, which are not implemented: `Unimplemented`,
/// reason `AS_OF`, field `as_of`.
absl::Status AsOfError();

/// Reads the requested box of a map; none means the whole map. `message` is null if the request has
/// no box. Errors: those of `v1::Box`, below the field `box`.
absl::StatusOr<std::optional<Box>> ReadBox(const v1::Box* message);

/// Returns the requested volumes, each once: the background first, then objects by ascending id.
/// Returns all shown volumes if `object_ids` is empty. Errors: `NotFound` with the field
/// `object_ids[i]`.
absl::StatusOr<std::vector<PlacedVolume>> SelectVolumes(
    const MapSnapshot& snapshot, const google::protobuf::RepeatedField<std::uint64_t>& object_ids);

/// Reads the classes of a filter. Errors: `InvalidArgument` with the field `class_ids` for more
/// than 1000 classes, with `class_ids[i]` for an id that no map can contain.
absl::StatusOr<std::set<ClassId>> ReadClassFilter(
    const google::protobuf::RepeatedField<std::uint32_t>& class_ids);

/// Returns OK if a filter contains at most 1000 values. Errors: `InvalidArgument` with the field.
absl::Status CheckFilterSize(std::string_view field, int size);

}  // namespace steadymap
