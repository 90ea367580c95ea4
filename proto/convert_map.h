#pragma once

#include <vector>

#include <absl/status/statusor.h>

#include "core/types/map_config.h"

#include "steadymap/v1/map.pb.h"

namespace steadymap {

/// Rows that a class table may have. The largest vocabularies of segmentation data sets have 1203
/// (LVIS) and 3688 (all of ADE20K) classes. Maps of earlier versions may have more.
inline constexpr int kMaxClasses = 4096;

/// A map's configuration with the defaults of map.proto filled in for what is absent or zero.
/// Errors: as `ValidateMapConfig`, and `BAD_VALUE` for a policy, a motion or a class id that is
/// unknown or out of range; field paths are relative to the message. Pure, any thread.
absl::StatusOr<MapConfig> FromProto(const v1::MapConfig& message);
v1::MapConfig ToProto(const MapConfig& config);

/// The class table of a configuration. Errors: `BAD_VALUE` with the field `classes[i]` and further.
absl::StatusOr<std::vector<SemanticClass>> ReadClasses(const v1::MapConfig& message);

/// Errors: `BAD_VALUE` with the field `policy` for one that is unknown.
absl::StatusOr<UpdatePolicy> FromProto(v1::UpdatePolicy policy);
v1::UpdatePolicy ToProto(UpdatePolicy policy);

}  // namespace steadymap
