#pragma once

#include <vector>

#include <absl/status/statusor.h>

#include "core/types/map_config.h"

#include "steadymap/v1/map.pb.h"

namespace steadymap {

/// Maximum number of rows of a class table. The largest vocabularies of segmentation data sets have
/// 1203 (LVIS) and 3688 (all of ADE20K) classes. Maps of earlier versions may have more rows.
inline constexpr int kMaxClasses = 4096;

/// The configuration of a map; absent and zero fields get the defaults of map.proto.
/// Errors: those of `ValidateMapConfig`, and `BAD_VALUE` for an unknown policy, an unknown motion
/// or a class id out of range; field paths are relative to the message. Pure, any thread.
absl::StatusOr<MapConfig> FromProto(const v1::MapConfig& message);
v1::MapConfig ToProto(const MapConfig& config);

/// The class table of a configuration. Errors: `BAD_VALUE` with a field path that begins with
/// `classes`.
absl::StatusOr<std::vector<SemanticClass>> ReadClasses(const v1::MapConfig& message);

/// The update policy of a request; unspecified: the default. Errors: `BAD_VALUE` with the field
/// `policy` for an unknown policy.
absl::StatusOr<UpdatePolicy> FromProto(v1::UpdatePolicy policy);
v1::UpdatePolicy ToProto(UpdatePolicy policy);

}  // namespace steadymap
