#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "client/picture/top_down_raster.h"
#include "core/frame/frame.h"
#include "core/geometry/cuboid.h"
#include "core/volume/mesh.h"

/// The bird's-eye picture of a map: its surface from straight above, where robots drove, and what a
/// reader needs to make sense of it.
namespace steadymap {

/// Where a robot was, in the order it was there.
struct RobotPath {
  std::string robot;                             ///< Id, for the legend.
  std::vector<Eigen::Vector3d> positions_world;  ///< Metres.
};

/// An object as its cuboid from above.
struct ObjectMark {
  Cuboid cuboid;
  double stationarity = 0.0;  ///< E[v], in [0, 1]: the colour. Of no meaning for ghosts.
  bool is_ghost = false;      ///< It stood there and no longer does: a broken grey outline.
};

/// How a picture is made. (The braces let designated initializers leave members out.)
struct BirdsEyeOptions {
  std::string title{};     ///< One line, ASCII; cut where it does not fit.
  std::string subtitle{};  ///< One smaller line under it.
  /// Length of the picture's longer side, pixels, in [600, 8000].
  int longest_side_px = 1200;
  /// Surfaces show the mesh's colours, where it has any, instead of their height.
  bool use_mesh_colors = true;
  /// Surface above this is left out, metres. Absent: ChooseCutHeight.
  std::optional<double> cut_height_m{};
};

/// A picture and how to find things in it.
struct BirdsEyePicture {
  Image<Rgb> image;
  TopDownView view;                    ///< Where the world lies, in pixel coordinates of `image`.
  std::optional<double> cut_height_m;  ///< Height above which surface was left out.
  double scale_bar_m = 0.0;            ///< Length that the scale bar stands for.
  Eigen::Vector2i scale_bar_px;        ///< Left end of the scale bar's top edge.
};

/// Draws a mesh, paths and objects on top of them, lower ones first. Degenerate input gives a
/// picture too: one without surface says so, and is sized by the paths or, without any, is 10 m
/// wide. The view holds all paths and all surface but the outermost 0.05 % of vertices on each
/// side, so that a few stray ones do not shrink the rest. Same input, same picture. Cost: 0.7 s for
/// 300 000 triangles.
BirdsEyePicture DrawBirdsEye(const Mesh& mesh,
                             const std::vector<RobotPath>& paths,
                             const std::vector<ObjectMark>& objects,
                             const BirdsEyeOptions& options);

/// The same without objects.
BirdsEyePicture DrawBirdsEye(const Mesh& mesh,
                             const std::vector<RobotPath>& paths,
                             const BirdsEyeOptions& options);

/// The height, metres, from which surface is left out so that a ceiling does not hide the room;
/// none if there is no ceiling.
///
/// Rule: a ceiling is surface that faces down, lies above every robot, fills a layer 0.4 m thick
/// with at least an eighth of the area that all upward-facing surface covers, and lies in the upper
/// half of the mesh. The cut is 0.1 m under the lowest such layer.
std::optional<double> ChooseCutHeight(const Mesh& mesh, const std::vector<RobotPath>& paths);

}  // namespace steadymap
