#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Geometry>

#include "client/bench/simulator/scene/scene.h"
#include "client/bench/simulator/sensor/facet_raster.h"
#include "client/bench/simulator/sensor/sensor_model.h"
#include "core/frame/frame.h"
#include "core/geometry/geometry.h"

namespace steadymap {

/// The first surface hit by the ray of each pixel, without noise.
struct SurfaceImage {
  /// Depths, and for each pixel the index into `surfaces`.
  DepthBuffer pixels;

  /// A facet in view.
  struct Surface {
    const SceneObject* object = nullptr;  ///< Null for entry 0, which means no surface.
    float plane_distance_m = 0.0F;        ///< Distance of the camera from the facet's plane, >= 0.
    float brightness = 0.0F;              ///< Share of the object's colour, by diffuse light.
  };

  std::vector<Surface> surfaces;  ///< Never empty once rendered.
};

/// Optional images of a frame besides depth and labels.
struct RenderOptions {
  bool include_instances = false;
  bool include_color = false;
};

/// One view to be rendered.
struct View {
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();  ///< The true pose.
  double time_s = 0.0;  ///< Since the start of the sequence; sets the poses of moving objects.
  std::uint64_t noise_key = 0;       ///< Determines the noise; use a different key for each frame.
  std::uint64_t slow_noise_key = 0;  ///< Of noise that changes slowly: one key for a sequence.
};

/// Renders a scene for a depth camera. Equal arguments give equal bits, independent of earlier
/// calls. Reuses its buffers, so one renderer draws many frames cheaply; not thread-safe.
class Renderer {
 public:
  /// `scene` must outlive the renderer and not change. `camera` must be valid.
  Renderer(const Scene* scene, const PinholeCamera& camera, const SensorModel& sensor);
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  /// Casts the ray of every pixel. The result is valid until the next call.
  const SurfaceImage& RenderSurfaces(const Eigen::Isometry3d& T_world_camera, double time_s);

  /// Returns a frame with millimetre depth, labels and the images selected by `options`, with all
  /// noise except drift: `T_world_camera` is the true pose. Robot and capture time are left empty.
  Frame Render(const View& view, const RenderOptions& options);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace steadymap
