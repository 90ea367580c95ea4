#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "client/picture/birds_eye.h"
#include "client/picture/canvas.h"

/// Private to the bird's-eye picture: objects as cuboids.
namespace steadymap {

/// Returns the colour of an expected stationarity: from orange (0: absent) over sand to blue (1:
/// stationary). Distinguishable with any kind of colour vision. `stationarity` is clamped to [0,
/// 1].
Rgb StationarityColor(double stationarity);

/// Extends `extent_world` to contain all objects with finite cuboids.
void ExtendToObjects(const std::vector<ObjectMark>& objects, Eigen::AlignedBox2d* extent_world);

/// Draws the outlines of objects with finite cuboids, ghosts below the others.
void DrawObjects(const std::vector<ObjectMark>& objects, const TopDownView& view, Canvas* canvas);

/// Draws the legend of the outlines downwards from `origin_px`; returns the y coordinate of its
/// end.
double DrawObjectLegend(const std::vector<ObjectMark>& objects,
                        const Eigen::Vector2d& origin_px,
                        Canvas* canvas);

}  // namespace steadymap
