#pragma once

#include <cstdint>

#include "client/bench/simulator/scene/shape.h"
#include "core/frame/frame.h"
#include "core/geometry/geometry.h"

namespace steadymap {

/// The nearest surface along each pixel's ray.
struct DepthBuffer {
  Image<float> inverse_depth_per_m;  ///< 0 without a hit.
  Image<std::uint32_t> surface;      ///< The number passed with the facet; 0 without a hit.
};

/// A facet in the camera frame, ready to be drawn.
struct CameraFacet {
  Facet facet_camera;             ///< Vertices in the camera frame.
  Eigen::Vector3d normal;         ///< Unit, towards the outside, camera frame.
  double plane_distance_m = 0.0;  ///< `normal . p` of its points: negative if seen from outside.
};

/// Prepares a facet for drawing; false if it is invisible: it faces away, or its plane contains the
/// camera centre.
bool FaceCamera(const Facet& facet_world,
                const Eigen::Isometry3d& T_camera_world,
                CameraFacet* facet);

/// Draws a facet into the buffer where it is nearer than the present content. A pixel is covered if
/// the ray through its centre hits the facet, borders included; facets with a common edge leave no
/// gap, and no facet needs clipping at the camera's plane.
///
/// Exact except for one rounding to float: along a row the inverse depth of a plane is linear.
void DrawFacet(const CameraFacet& facet,
               const PinholeCamera& camera,
               std::uint32_t surface,
               DepthBuffer* buffer);

}  // namespace steadymap
