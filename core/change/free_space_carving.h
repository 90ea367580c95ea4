#pragma once

#include <Eigen/Core>

#include "core/association/sample_grid.h"
#include "core/working/working_map.h"

namespace steadymap {

/// Marks what a frame looks through as free space, from a little before the camera to a little
/// before the surface. `camera_world`: its centre, metres. `session_start`: of its session.
void CarveFreeSpace(const SampleGrid& samples,
                    const Eigen::Vector3d& camera_world,
                    Timestamp session_start,
                    WorkingMap* map);

}  // namespace steadymap
