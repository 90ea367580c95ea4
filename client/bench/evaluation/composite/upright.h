#pragma once

#include <vector>

#include <Eigen/Geometry>

namespace steadymap {

/// Returns the rotation after which most level surface faces up, from unit normals of surface in a
/// frame whose z axis is up within 45 degrees. The heading changes as little as possible. The
/// identity without normals in that range.
Eigen::Quaterniond UprightRotation(const std::vector<Eigen::Vector3f>& normals);

}  // namespace steadymap
