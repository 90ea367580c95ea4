#pragma once

#include <string>
#include <vector>

#include "client/picture/birds_eye.h"
#include "client/picture/birds_eye_scene.h"
#include "client/picture/canvas.h"

/// Private to the bird's-eye picture: elements around and on top of the surface.
namespace steadymap {

/// Returns the largest 1, 2 or 5 times a power of ten that is at most `limit`, which must be above
/// 0.
double RoundLength(double limit);

/// Returns a decimal number without trailing zeros.
std::string Decimal(double value);

/// Returns the colour of the i-th path; the colours repeat after eight.
Rgb PathColor(std::size_t path);

/// Draws faint grid lines with a spacing of `step_m` over the box of the view.
void DrawGrid(const TopDownView& view, double step_m, Canvas* canvas);

/// Draws each path with a disc at its start and a ring at its end.
void DrawPaths(const std::vector<RobotPath>& paths, const TopDownView& view, Canvas* canvas);

/// Draws a scale bar of `length_m` with its top left corner at `origin_px`.
void DrawScaleBar(double length_m,
                  double metres_per_px,
                  const Eigen::Vector2i& origin_px,
                  Canvas* canvas);

/// Draws the directions of the world's x and y axes from a corner at `origin_px`.
void DrawAxes(const Eigen::Vector2d& origin_px, Canvas* canvas);

/// Draws the height ramp downwards from `origin_px`; returns the y coordinate of its end.
double DrawHeightLegend(const BirdsEyeScene& scene,
                        const Eigen::Vector2d& origin_px,
                        double ramp_height_px,
                        Canvas* canvas);

/// Draws one row per path, at most eight, and the meaning of the marks.
void DrawPathLegend(const std::vector<RobotPath>& paths,
                    const Eigen::Vector2d& origin_px,
                    double width_px,
                    Canvas* canvas);

/// Returns `text`, truncated with two dots if it is wider than `width_px`.
std::string Fit(std::string text, double cap_height_px, double width_px);

}  // namespace steadymap
