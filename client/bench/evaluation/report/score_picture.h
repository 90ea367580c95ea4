#pragma once

#include <string>
#include <vector>

#include "client/bench/evaluation/score/map_score.h"
#include "core/frame/frame.h"

namespace steadymap {

/// Texts around the picture.
struct ScorePictureText {
  std::string title;     ///< One line, ASCII; truncated if too long.
  std::string subtitle;  ///< One smaller line below the title.
};

/// Draws voxel verdicts from above: one square per column of voxels, in the colour of its most
/// frequent verdict (the worse of equal ones), paler for columns with few voxels, and a legend with
/// counts. Without verdicts the picture contains a message.
Image<Rgb> DrawScorePicture(const std::vector<JudgedVoxel>& voxels,
                            double voxel_size_m,
                            const ScorePictureText& text);

}  // namespace steadymap
