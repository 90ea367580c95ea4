#pragma once

#include <string>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <google/protobuf/field_mask.pb.h>

#include "server/config/server_config.h"
#include "server/mapping/map_runtime.h"

#include "steadymap/v1/map_service.pb.h"

namespace steadymap {

/// Returns the id in `tenants/{tenant}`, not checked; empty if `parent` has another format.
std::string TenantOf(const std::string& parent);

/// Makes the resource of a map with its current state. If the record of the map is damaged, only
/// name, etag and state are set.
v1::Map MakeMapResource(const MapRuntime& map);

/// Returns the etag. It changes with every change of the record, and differs between successive
/// maps of the same name.
std::string EtagOf(const MapRecord& record);

/// Returns OK if `etag` is empty or matches the record. Errors: `Aborted` with reason
/// `ETAG_MISMATCH`.
absl::Status CheckEtag(const MapRecord& record, const std::string& etag, std::string_view field);

/// Checks the length of a request's id. Errors: `InvalidArgument` with the field `request_id`.
absl::Status CheckRequestId(const std::string& request_id);

/// Makes the record for a request to create a map, without the key and the fields of the store. A
/// missing retention is replaced by `defaults`. Errors: `InvalidArgument` with the field's path in
/// the request.
absl::StatusOr<MapRecord> ReadNewMap(const v1::CreateMapRequest& request,
                                     const RetentionOptions& defaults);

/// Copies the fields in `mask` from `map` to `record`, except the class table. Errors:
/// `InvalidArgument` with the field `update_mask` for an empty mask and for paths that cannot be
/// changed, or with the path of an invalid value.
absl::Status ApplyUpdate(const v1::Map& map,
                         const google::protobuf::FieldMask& mask,
                         const RetentionOptions& defaults,
                         MapRecord* record);

/// Returns the rows of the class table of `map` that `present` does not contain; none if `mask`
/// does not contain the class table. Errors: `InvalidArgument` with the field's path if a row of
/// `present` is missing or changed.
absl::StatusOr<std::vector<SemanticClass>> ReadAddedClasses(
    const v1::Map& map,
    const google::protobuf::FieldMask& mask,
    const std::vector<SemanticClass>& present);

/// Clears all fields that `mask` does not contain. Errors: `InvalidArgument` with the field
/// `read_mask`.
absl::Status ApplyReadMask(const google::protobuf::FieldMask& mask, v1::Map* map);

}  // namespace steadymap
