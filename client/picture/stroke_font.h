#pragma once

#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace steadymap {

/// A polyline to be drawn with a round pen, pixels, y down.
using Stroke = std::vector<Eigen::Vector2d>;

/// Returns the strokes of a line of text with its baseline starting at `origin_px` and capitals of
/// height `cap_height_px`. ASCII only; a control byte becomes a question mark, and so does
/// each run of bytes above 127.
std::vector<Stroke> TextStrokes(std::string_view text,
                                const Eigen::Vector2d& origin_px,
                                double cap_height_px);

/// Returns the width of a line of text without the pen's width, pixels. 0 for empty text.
double TextWidth(std::string_view text, double cap_height_px);

}  // namespace steadymap
