#pragma once

#include <optional>
#include <vector>

#include "core/association/association.h"
#include "core/association/sample_grid.h"

namespace steadymap {

/// Height of the ground that a frame shows, metres above the world's origin: the lowest level that
/// holds a good share of the surface that faces up, if next to nothing is seen below it: else it is
/// a table's top. None if there is no such level below the camera.
std::optional<double> FindGroundHeight(const SampleGrid& samples, double camera_height_m);

/// Gives the samples of the ground to the background, whatever their labels say: the ground is
/// planar, labels are noisy.
void AssignGround(const SampleGrid& samples, double ground_height_m, Association* association);

}  // namespace steadymap
