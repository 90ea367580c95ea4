#pragma once

#include "client/picture/birds_eye_scene.h"
#include "client/picture/canvas.h"
#include "client/picture/top_down_raster.h"
#include "core/volume/mesh.h"

/// Private to the bird's-eye picture: the coloured surface, shaded so that steps in height are
/// visible from above.
namespace steadymap {

/// Paints the visible part of a mesh onto a canvas of the view's size, in the mesh's colours or, if
/// `use_mesh_colors` is false, in the colours of its heights.
void PaintSurface(const Mesh& mesh,
                  const BirdsEyeScene& scene,
                  const TopDownView& view,
                  bool use_mesh_colors,
                  Canvas* map);

}  // namespace steadymap
