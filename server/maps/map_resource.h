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

/// The id in `tenants/{tenant}`, as it stands; empty if `parent` reads otherwise.
std::string TenantOf(const std::string& parent);

/// The map as a resource, with what it holds now. A map in quarantine has a name and an etag only.
v1::Map MakeMapResource(const MapRuntime& map);

/// Changes with every change of the record, and with every map of the same name.
std::string EtagOf(const MapRecord& record);

/// OK if `etag` is empty or the record's. Errors: `Aborted` with reason `ETAG_MISMATCH`.
absl::Status CheckEtag(const MapRecord& record, const std::string& etag, std::string_view field);

/// OK if a request's id is not too long. Errors: `InvalidArgument` with the field `request_id`.
absl::Status CheckRequestId(const std::string& request_id);

/// The record that a request asks to create, key and store's fields left out. Absent retention
/// takes `defaults`. Errors: `InvalidArgument` with the field's path in the request.
absl::StatusOr<MapRecord> ReadNewMap(const v1::CreateMapRequest& request,
                                     const RetentionOptions& defaults);

/// Changes those fields of `record` that `mask` names to what `map` holds; the class table is not
/// one of them. Errors:
/// `InvalidArgument` with the field `update_mask` for an empty mask and for paths that cannot be
/// changed, or with the path of a wrong value.
absl::Status ApplyUpdate(const v1::Map& map,
                         const google::protobuf::FieldMask& mask,
                         const RetentionOptions& defaults,
                         MapRecord* record);

/// The rows by which the class table of `map` is longer than `present`; none if `mask` does not
/// name it. Errors: `InvalidArgument` with the field's path if a present row is missing or changed.
absl::StatusOr<std::vector<SemanticClass>> ReadAddedClasses(
    const v1::Map& map,
    const google::protobuf::FieldMask& mask,
    const std::vector<SemanticClass>& present);

/// Clears what `mask` does not name. Errors: `InvalidArgument` with the field `read_mask`.
absl::Status ApplyReadMask(const google::protobuf::FieldMask& mask, v1::Map* map);

}  // namespace steadymap
