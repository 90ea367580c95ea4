#pragma once

#include "core/frame/frame.h"

namespace steadymap {

/// The colour of a height: `share` is 0 at the lowest and 1 at the highest and is clamped.
///
/// Lightness falls and hue turns steadily from pale sand over green and blue to deep violet, in a
/// space (Oklab) where equal steps look equal, so that heights also read in grey and for the
/// colour-blind.
Rgb HeightColor(double share);

}  // namespace steadymap
