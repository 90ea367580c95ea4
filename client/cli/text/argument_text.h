#pragma once

#include <array>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <absl/status/statusor.h>

#include "core/geometry/geometry.h"
#include "core/types/identifiers.h"
#include "core/types/map_config.h"
#include "core/types/timestamp.h"

/// Parsers for command-line arguments that CLI11 does not support. All errors are `InvalidArgument`
/// with the expected and the actual text in the message.
namespace steadymap {

/// Parses a map name: its id in the tenant `default`, or its whole name
/// `tenants/{tenant}/maps/{map}`.
absl::StatusOr<MapName> ParseMapArgument(std::string_view text);

/// Parses a point `x,y,z` in the world frame, metres, finite.
absl::StatusOr<Eigen::Vector3d> ParsePoint(std::string_view text);

/// Parses a box `x0,y0,z0,x1,y1,z1` from its lowest to its highest corner, world frame, metres,
/// finite.
absl::StatusOr<Box> ParseBox(std::string_view text);

/// Parses a time, `2024-05-01T12:00:00.25Z` (RFC 3339, any offset) or seconds since 1970,
/// `1714564800.25`, to a nanosecond; not before 1970 nor after 2261.
absl::StatusOr<Timestamp> ParseTime(std::string_view text);

/// Parses labels of a map, `key=value` each, without duplicate keys. A value may be empty and may
/// contain `=`. The server validates keys and values.
absl::StatusOr<std::map<std::string, std::string>> ParseLabels(
    const std::vector<std::string>& texts);

/// Parses parameters of a policy, `name=number` each; of those with one name, the last counts. The
/// map's configuration validates names and numbers.
absl::StatusOr<ParameterValues> ParseParameters(const std::vector<std::string>& texts);

/// Parses camera intrinsics `fx,fy,cx,cy`, pixels, finite.
absl::StatusOr<std::array<double, 4>> ParseIntrinsics(std::string_view text);

}  // namespace steadymap
