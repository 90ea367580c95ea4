#pragma once

#include "core/map/contradiction.h"
#include "core/map/robot_state.h"
#include "core/types/identifiers.h"

#include "steadymap/v1/robot.pb.h"

/// Conversion from core types to messages: robots. Pure functions, any thread.
namespace steadymap {

/// The message of a sensor of a robot, without the internal state of the mapper and without
/// contradictions, which are of objects.
v1::Robot ToProto(const SensorName& name, const RobotState& state);

v1::SensorContradiction ToProto(const SensorContradiction& contradiction);

}  // namespace steadymap
