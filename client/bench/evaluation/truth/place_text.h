#pragma once

#include <string>

#include <Eigen/Core>

namespace steadymap {

/// Returns a point as text, metres to the centimetre.
std::string PlaceText(const Eigen::Vector3d& point_world);

}  // namespace steadymap
