#pragma once

#include "core/frame/frame.h"

namespace steadymap {

/// Returns the colour of a height; `share` is 0 at the lowest and 1 at the highest height and is
/// clamped.
///
/// Lightness decreases and hue changes steadily from pale sand over green and blue to deep violet,
/// in the perceptually uniform space Oklab. The ramp is readable in greyscale and with any kind of
/// colour vision.
Rgb HeightColor(double share);

}  // namespace steadymap
