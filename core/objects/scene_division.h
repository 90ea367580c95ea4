#pragma once

#include "core/objects/gap_planes.h"
#include "core/objects/surface_overlap.h"
#include "core/working/tracked_object.h"
#include "core/working/working_map.h"

namespace steadymap {

/// The constants of `DivideScene`.
struct SceneDivisionParameters {
  /// Smallest area of a large plane, such as a floor or a wall, square metres, in all of its
  /// pieces together.
  double min_plane_area_m2 = 1.5;
  /// Largest angle between the normals of one plane, as a cosine; also between the vertical and
  /// the normal of surface that faces up.
  double min_plane_cosine = 0.85;
  /// Smallest level surface on which other things stand, square metres.
  double min_support_area_m2 = 0.2;
  /// Smallest surface of an object, square metres, times the weight of its voxels: 1 for one
  /// measurement from 1 m at normal incidence (`kWeightUnit`). Less may be noise of the depth.
  double min_weighted_area_m2 = 0.06;
  /// Parts that are closer are one object, voxels: narrow surface, such as the edge of a table, has
  /// gaps.
  double near_voxels = 2.25;
  /// What is narrower is not resolved on the floor, voxels: it may be what is left of the legs of a
  /// table. On level surface of another part, only what has the shape of a leg is none.
  double min_width_voxels = 3.0;
  /// Largest share of the width of a leg in its length.
  double max_leg_share = 0.3;
  GapPlaneParameters gaps;

  friend bool operator==(const SceneDivisionParameters&, const SceneDivisionParameters&) = default;
};

/// True if an object is a structure: a present one without a given extent with as much surface as a
/// wall, such as a row of cabinets. Later sessions fuse only what is not known of it, and what they
/// see on it is apart from it.
bool IsStructure(const TrackedObject& object, const SceneDivisionParameters& parameters);

/// Divides surface that was fused without labels into objects: connected surface apart from large
/// planes and from structures. What is on a large plane, on known background or too small goes to
/// the background, and `scene` is deleted. The new objects are tentative and have the state of
/// `scene`. `surface` tells which points are in contact and which are on known background.
void DivideScene(const SceneDivisionParameters& parameters,
                 const SurfaceMatchParameters& surface,
                 TrackedObject* scene,
                 WorkingMap* map);

}  // namespace steadymap
