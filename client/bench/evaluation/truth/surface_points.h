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

/// Samples every triangle with neighbouring points at most about `spacing_m` (> 0) apart. Triangles
/// without area have no points.
std::vector<SurfacePoint> SampleMesh(const Mesh& mesh, double spacing_m);

/// Samples every facet on a grid of at most `spacing_m` (> 0), with points at the cell centres;
/// deterministic. Facets are parallelograms or triangles.
std::vector<SurfacePoint> SampleFacets(const std::vector<Facet>& facets_world, double spacing_m);

/// Samples the surface of an object's volume at the object's pose.
std::vector<SurfacePoint> SampleObject(const MapObject& object,
                                       const VoxelScale& scale,
                                       double spacing_m);

/// Samples the whole visible surface of a map: background and present objects.
std::vector<SurfacePoint> SampleMap(const MapSnapshot& snapshot, double spacing_m);

}  // namespace steadymap
