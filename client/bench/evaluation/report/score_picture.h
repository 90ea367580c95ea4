#pragma once

#include <string>
#include <vector>

#include "client/bench/evaluation/score/map_score.h"
#include "core/frame/frame.h"

namespace steadymap {

/// What stands around the picture.
struct ScorePictureText {
  std::string title;     ///< One line, ASCII; cut where it does not fit.
  std::string subtitle;  ///< One smaller line under it.
};

/// Draws verdicts from straight above: a square a column of voxels, in the colour of the verdict
/// that most of them got (of equal ones the worse), paler where the column holds few, with a legend
/// that counts them. No verdicts give an empty picture that says so.
Image<Rgb> DrawScorePicture(const std::vector<JudgedVoxel>& voxels,
                            double voxel_size_m,
                            const ScorePictureText& text);

}  // namespace steadymap
