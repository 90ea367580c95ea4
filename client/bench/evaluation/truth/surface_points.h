#pragma once

#include <vector>

#include <Eigen/Core>

#include "client/bench/simulator/scene/shape.h"
#include "core/map/map_object.h"
#include "core/map/map_snapshot.h"
#include "core/volume/mesh.h"

namespace steadymap {

/// A point of a surface.
struct SurfacePoint {
  Eigen::Vector3f position_world = Eigen::Vector3f::Zero();  ///< Metres.
  Eigen::Vector3f normal_world = Eigen::Vector3f::Zero();    ///< Unit, towards the outside.
};

/// Points on every triangle, no two neighbours more than about `spacing_m` (> 0) apart. Triangles
/// without area have none.
std::vector<SurfacePoint> SampleMesh(const Mesh& mesh, double spacing_m);

/// Points on every facet, on a grid of `spacing_m` (> 0) or a little less, each in the middle of
/// its cell; the same facets give the same points. Facets are parallelograms or triangles.
std::vector<SurfacePoint> SampleFacets(const std::vector<Facet>& facets_world, double spacing_m);

/// The surface of an object's volume, where the object stands.
std::vector<SurfacePoint> SampleObject(const MapObject& object,
                                       const VoxelScale& scale,
                                       double spacing_m);

/// All surface that a map shows: what a reader of the map takes to be there.
std::vector<SurfacePoint> SampleMap(const MapSnapshot& snapshot, double spacing_m);

}  // namespace steadymap
