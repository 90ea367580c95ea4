#pragma once

#include <absl/status/statusor.h>

#include "core/map/robot_state.h"

namespace steadymap::storage::v1 {
class RobotRecord;
}  // namespace steadymap::storage::v1

/// What the store keeps of robots, as protobuf and back. Reading back gives bit for bit what was
/// written. Errors of the latter: `DataLoss` for what the former cannot have written.
namespace steadymap {

storage::v1::RobotRecord ToProto(const RobotState& state);
absl::StatusOr<RobotState> FromProto(const storage::v1::RobotRecord& record);

}  // namespace steadymap
