#pragma once

#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace steadymap {

/// A line of points to be drawn with a round pen, pixels, y down.
using Stroke = std::vector<Eigen::Vector2d>;

/// The strokes of a line of text whose baseline starts at `origin_px` and whose capitals are
/// `cap_height_px` tall. ASCII only; any other byte becomes a question mark, a run of bytes above
/// 127 one.
std::vector<Stroke> TextStrokes(std::string_view text,
                                const Eigen::Vector2d& origin_px,
                                double cap_height_px);

/// Width of the same line, without the pen's, pixels. 0 for empty text.
double TextWidth(std::string_view text, double cap_height_px);

}  // namespace steadymap
