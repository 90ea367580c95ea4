#pragma once

#include "core/map/robot_state.h"
#include "core/types/identifiers.h"

#include "steadymap/v1/robot.pb.h"

/// Conversion from core types to messages: robots. Pure functions, any thread.
namespace steadymap {

/// The message of a sensor of a robot, without the internal state of the mapper.
v1::Robot ToProto(const SensorName& name, const RobotState& state);

}  // namespace steadymap
