#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "client/picture/birds_eye.h"
#include "client/picture/canvas.h"

/// Private to the bird's-eye picture: objects as cuboids.
namespace steadymap {

/// The colour of an expected stationarity, from orange (0: gone) over sand to blue (1: stays),
/// which people with any kind of colour vision tell apart. `stationarity` is clamped to [0, 1].
Rgb StationarityColor(double stationarity);

/// Widens an extent so that it holds all objects; those that are not finite are left out.
void ExtendToObjects(const std::vector<ObjectMark>& objects, Eigen::AlignedBox2d* extent_world);

/// Outlines objects, ghosts beneath the others. Cuboids that are not finite are left out.
void DrawObjects(const std::vector<ObjectMark>& objects, const TopDownView& view, Canvas* canvas);

/// Draws what the outlines mean, downwards from `origin_px`; returns where it ends.
double DrawObjectLegend(const std::vector<ObjectMark>& objects,
                        const Eigen::Vector2d& origin_px,
                        Canvas* canvas);

}  // namespace steadymap
