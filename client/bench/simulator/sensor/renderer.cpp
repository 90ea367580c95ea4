#include "client/bench/simulator/sensor/renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "client/bench/simulator/sensor/depth_sensor.h"
#include "client/bench/simulator/sensor/label_noise.h"

namespace steadymap {
namespace {

// Direction of the light, and share of ambient light.
const Eigen::Vector3d kLightWorld = Eigen::Vector3d(0.35, 0.55, 0.76).normalized();
constexpr double kAmbientShare = 0.45;

// The facets of one object in the world frame, computed once for static objects.
struct ObjectFacets {
  double radius_m = 0.0;
  std::vector<Facet> facets_world;
};

// Returns the four side planes of the view frustum: inward unit normals, camera frame.
std::array<Eigen::Vector3d, 4> FrustumSides(const PinholeCamera& camera) {
  const double left = -0.5;
  const double right = camera.width_px - 0.5;
  const double bottom = camera.height_px - 0.5;
  const std::array<Eigen::Vector3d, 4> corners = {camera.Ray(left, left),
                                                  camera.Ray(right, left),
                                                  camera.Ray(right, bottom),
                                                  camera.Ray(left, bottom)};
  std::array<Eigen::Vector3d, 4> sides;
  for (std::size_t i = 0; i < 4; ++i) {
    sides[i] = corners[i].cross(corners[(i + 1) % 4]).normalized();
  }
  return sides;
}

float BrightnessOf(const Eigen::Vector3d& normal_world) {
  return static_cast<float>(kAmbientShare +
                            (1 - kAmbientShare) * std::abs(normal_world.dot(kLightWorld)));
}

Rgb Shade(const Rgb& color, float brightness) {
  Rgb shaded;
  for (std::size_t i = 0; i < color.size(); ++i) {
    shaded[i] = static_cast<std::uint8_t>(std::lround(static_cast<float>(color[i]) * brightness));
  }
  return shaded;
}

// Assigns each pixel the value of its surface.
template <typename Pixel>
Image<Pixel> PaintSurfaces(const SurfaceImage& surfaces, const std::vector<Pixel>& values) {
  const Image<std::uint32_t>& surface = surfaces.pixels.surface;
  Image<Pixel> image(surface.width_px(), surface.height_px());
  const std::uint32_t* from = surface.data();
  Pixel* to = image.data();
  for (std::size_t i = 0; i < image.size(); ++i) to[i] = values[from[i]];
  return image;
}

// Returns a value for each surface; entry 0, no surface, keeps the default.
template <typename Value, typename Function>
std::vector<Value> ForEachSurface(const SurfaceImage& surfaces, Function function) {
  std::vector<Value> values(surfaces.surfaces.size(), Value{});
  for (std::size_t i = 1; i < values.size(); ++i) values[i] = function(surfaces.surfaces[i]);
  return values;
}

}  // namespace

struct Renderer::State {
  State(const Scene* scene_in, const PinholeCamera& camera_in, const SensorModel& sensor_in)
      : scene(scene_in),
        camera(camera_in),
        sensor(sensor_in),
        depth_sensor(sensor_in, camera_in),
        sides(FrustumSides(camera_in)) {}

  // True if a part of a sphere can be in the picture and within range.
  bool Sees(const Eigen::Vector3d& center_camera, double radius_m) const {
    if (center_camera.z() < -radius_m || center_camera.z() > sensor.visible_range_m + radius_m) {
      return false;
    }
    return std::all_of(sides.begin(), sides.end(), [&](const Eigen::Vector3d& side) {
      return side.dot(center_camera) >= -radius_m;
    });
  }

  void DrawObject(const SceneObject& object,
                  const std::vector<Facet>& facets_world,
                  const Eigen::Isometry3d& T_camera_world) {
    CameraFacet facet;
    for (const Facet& facet_world : facets_world) {
      if (!FaceCamera(facet_world, T_camera_world, &facet)) continue;
      const auto surface = static_cast<std::uint32_t>(view.surfaces.size());
      view.surfaces.push_back({&object,
                               static_cast<float>(std::abs(facet.plane_distance_m)),
                               BrightnessOf(T_camera_world.linear().transpose() * facet.normal)});
      DrawFacet(facet, camera, surface, &view.pixels);
    }
  }

  const Scene* scene;
  PinholeCamera camera;
  SensorModel sensor;
  DepthSensor depth_sensor;
  std::array<Eigen::Vector3d, 4> sides;
  std::vector<ObjectFacets> objects;  // Parallel to `scene->objects()`.
  SurfaceImage view;
};

Renderer::Renderer(const Scene* scene, const PinholeCamera& camera, const SensorModel& sensor)
    : state_(std::make_unique<State>(scene, camera, sensor)) {
  for (const SceneObject& object : scene->objects()) {
    ObjectFacets facets;
    facets.radius_m = BoundingRadiusM(object.shape);
    if (!object.moves()) facets.facets_world = FacetsOf(object.shape, object.T_world_object);
    state_->objects.push_back(std::move(facets));
  }
  state_->view.pixels = {Image<float>(camera.width_px, camera.height_px),
                         Image<std::uint32_t>(camera.width_px, camera.height_px)};
}

Renderer::~Renderer() = default;

const SurfaceImage& Renderer::RenderSurfaces(const Eigen::Isometry3d& T_world_camera,
                                             double time_s) {
  SurfaceImage& view = state_->view;
  // Initialised to the inverse of the visible range, the buffer hides all farther surface.
  const auto horizon = static_cast<float>(1 / state_->sensor.visible_range_m);
  DepthBuffer& pixels = view.pixels;
  std::fill_n(pixels.inverse_depth_per_m.data(), pixels.inverse_depth_per_m.size(), horizon);
  std::fill_n(pixels.surface.data(), pixels.surface.size(), 0U);
  view.surfaces.assign(1, {});
  const Eigen::Isometry3d T_camera_world = T_world_camera.inverse();
  for (std::size_t i = 0; i < state_->objects.size(); ++i) {
    const SceneObject& object = state_->scene->objects()[i];
    const ObjectFacets& facets = state_->objects[i];
    const Eigen::Isometry3d T_world_object = object.PoseAt(time_s);
    if (!state_->Sees(T_camera_world * T_world_object.translation(), facets.radius_m)) continue;
    if (object.moves()) {
      state_->DrawObject(object, FacetsOf(object.shape, T_world_object), T_camera_world);
    } else {
      state_->DrawObject(object, facets.facets_world, T_camera_world);
    }
  }
  float* inverse_depth = pixels.inverse_depth_per_m.data();
  const std::uint32_t* surface = pixels.surface.data();
  for (std::size_t i = 0; i < pixels.surface.size(); ++i) {
    inverse_depth[i] = surface[i] != 0 ? inverse_depth[i] : 0.0F;
  }
  return view;
}

Frame Renderer::Render(const View& view, const RenderOptions& options) {
  using Surface = SurfaceImage::Surface;
  const SurfaceImage& surfaces = RenderSurfaces(view.T_world_camera, view.time_s);
  Frame frame;
  frame.camera = state_->camera;
  frame.T_world_camera = view.T_world_camera;
  frame.depth.units =
      state_->depth_sensor.Measure(surfaces, {view.noise_key, view.slow_noise_key, view.time_s});
  frame.depth.sensor = DepthSensorKind::kStereo;
  frame.labels =
      PaintSurfaces(surfaces, ForEachSurface<std::uint16_t>(surfaces, [&](const Surface& surface) {
                      return ShownClass(state_->sensor, view.noise_key, *surface.object);
                    }));
  AddLabelNoise(state_->sensor, view.noise_key, &frame.labels);
  if (options.include_instances) {
    frame.instances =
        PaintSurfaces(surfaces, ForEachSurface<std::uint16_t>(surfaces, [](const Surface& surface) {
                        return surface.object->instance;
                      }));
  }
  if (options.include_color) {
    frame.color = PaintSurfaces(surfaces, ForEachSurface<Rgb>(surfaces, [](const Surface& surface) {
                                  return Shade(surface.object->color, surface.brightness);
                                }));
  }
  return frame;
}

}  // namespace steadymap
