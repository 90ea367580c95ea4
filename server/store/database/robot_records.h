#pragma once

#include <absl/status/statusor.h>

#include "core/map/robot_state.h"

namespace steadymap::storage::v1 {
class RobotRecord;
}  // namespace steadymap::storage::v1

/// Converts the stored records of robots to protobuf and back. A round trip preserves every bit.
/// `FromProto` returns `DataLoss` for content that `ToProto` cannot have written.
namespace steadymap {

storage::v1::RobotRecord ToProto(const RobotState& state);
absl::StatusOr<RobotState> FromProto(const storage::v1::RobotRecord& record);

}  // namespace steadymap
