#pragma once

#include <cstdint>

#include "client/bench/simulator/scene/shape.h"
#include "core/frame/frame.h"
#include "core/geometry/geometry.h"

namespace steadymap {

/// The nearest surface found so far along each pixel's ray.
struct DepthBuffer {
  Image<float> inverse_depth_per_m;  ///< 0 where nothing was met.
  Image<std::uint32_t> surface;      ///< The number given with the facet; 0 where nothing was met.
};

/// A facet in the camera frame, ready to be drawn.
struct CameraFacet {
  Facet facet_camera;             ///< Vertices in the camera frame.
  Eigen::Vector3d normal;         ///< Unit, towards the outside, camera frame.
  double plane_distance_m = 0.0;  ///< `normal . p` of its points: negative when seen from outside.
};

/// Prepares a facet for drawing; false if the camera cannot see it: it looks away, or its plane
/// runs through the camera.
bool FaceCamera(const Facet& facet_world,
                const Eigen::Isometry3d& T_camera_world,
                CameraFacet* facet);

/// Draws a facet into the buffer where it is nearer than what is there. A pixel is covered if its
/// ray, cast through the pixel's centre, meets the facet, borders included; so facets that share an
/// edge leave no gap, and no facet needs clipping at the camera's plane.
///
/// Exact but for one rounding to float: along a row the inverse depth of a plane is linear.
void DrawFacet(const CameraFacet& facet,
               const PinholeCamera& camera,
               std::uint32_t surface,
               DepthBuffer* buffer);

}  // namespace steadymap
