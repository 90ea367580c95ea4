#pragma once

#include "client/picture/birds_eye_scene.h"
#include "client/picture/canvas.h"
#include "client/picture/top_down_raster.h"
#include "core/volume/mesh.h"

/// Private to the bird's-eye picture: the surface in colour, with the light and shade that let a
/// reader see steps in height from straight above.
namespace steadymap {

/// Paints what the scene shows of a mesh over a canvas of the view's size, in the mesh's colours
/// or, with `use_mesh_colors` unset, in those of its heights.
void PaintSurface(const Mesh& mesh,
                  const BirdsEyeScene& scene,
                  const TopDownView& view,
                  bool use_mesh_colors,
                  Canvas* map);

}  // namespace steadymap
