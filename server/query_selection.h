#pragma once

#include <cstdint>
#include <optional>

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <google/protobuf/repeated_field.h>

#include "core/geometry.h"

#include "steadymap/v1/geometry.pb.h"

namespace steadymap {

/// The part of a map that a request asks for; none for all of it. `message` is null where the
/// request has no box. Errors: as for `v1::Box`, below the field `box`.
absl::StatusOr<std::optional<Box>> ReadBox(const v1::Box* message);

/// OK if every object that a request names is there; the background always is. Errors: `NotFound`
/// with the field `object_ids[i]`.
absl::Status CheckObjects(const google::protobuf::RepeatedField<std::uint64_t>& object_ids);

}  // namespace steadymap
