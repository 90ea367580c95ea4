#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <absl/status/statusor.h>

#include "client/bench/simulator/scene/scene.h"
#include "client/bench/simulator/scene/trajectory.h"

/// The hall of the TorWIC-Mapping recordings and its scenarios.
///
/// World frame: the origin is the centre of the loop on the ground; +y is the top of the drawing in
/// the data set's documentation. Names of objects, and groups of touching objects:
/// - stacks `outer-{top,left,bottom,right}-{1,2,3}-{a,b}`, the rows outside the loop;
/// - stacks `inner-{side}-{a,b}` and `inner-{corner}-{a,b,c}`, the ring inside it;
/// - fences `fence-{corner}-{a,b}`, corners being `top-right`, `top-left`, ...;
/// - `tag-stand`, `tag-plate`, `floor`;
/// - `2-2-...` and `4-1-...`, the objects that those scenarios add.
namespace steadymap {

/// Returns the names of the configurations: `baseline`, then the scenarios `1-1` to `4-1`.
std::vector<std::string> TorwicConfigurations();

/// Builds the hall in one configuration; each scenario is a change of the baseline. Errors:
/// `InvalidArgument` for a name that is not in `TorwicConfigurations`.
absl::StatusOr<Scene> MakeTorwicHall(std::string_view configuration);

/// Returns the robot's path: once counter-clockwise round a 5 m square with rounded corners.
GroundPath TorwicLoop();

/// Returns the drive along `TorwicLoop` at 0.5 m/s, about 370 frames, camera 0.5 m above the
/// ground.
Trajectory DriveTorwicLoop();

}  // namespace steadymap
