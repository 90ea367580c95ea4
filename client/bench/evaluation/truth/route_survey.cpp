#include "client/bench/evaluation/truth/route_survey.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <unordered_set>
#include <utility>

#include "client/bench/evaluation/truth/voxel_index.h"
#include "client/bench/simulator/sensor/renderer.h"

namespace steadymap {
namespace {

// More oblique surface gives no depth (`SensorModel::grazing_cosine`), so it cannot be mapped.
constexpr float kMinCosine = 0.1F;

// Tolerance of the depth of a point's pixel: rounding, then a whole pixel along the slope.
constexpr float kSameDepthM = 0.005F;

// A ray that ends this far behind a point certainly passed through it.
constexpr float kBehindM = 0.05F;

// A place is in view in a frame that observes at least this much of it.
constexpr double kInViewM2 = 0.05;

constexpr double kSamePlaceM = 1e-6;

enum class Sight { kNone, kSeen, kLookedThrough };

/// A view prepared for many visibility tests.
class Viewer {
 public:
  Viewer(const DepthView& view, const SurveyOptions& options)
      : view_(view),
        T_camera_world_(view.T_world_camera.inverse().cast<float>()),
        eye_world_(view.T_world_camera.translation().cast<float>()),
        max_depth_m_(static_cast<float>(options.max_depth_m)),
        max_range_m_(static_cast<float>(SensorModel::Ideal().max_range_m)) {}

  Sight Look(const SurfacePoint& point) const {
    const Eigen::Vector3f p_camera = T_camera_world_ * point.position_world;
    const float depth_m = p_camera.z();
    if (depth_m < kMinDepthM || depth_m > max_depth_m_) return Sight::kNone;
    const Eigen::Vector2f pixel = view_.camera.Project(p_camera);
    if (!view_.camera.Contains(pixel)) return Sight::kNone;
    const Eigen::Vector2i nearest = (pixel.array() + 0.5F).floor().cast<int>();
    const float measured_m = view_.depth_m.At(nearest.x(), nearest.y());
    if (measured_m > max_range_m_) return Sight::kNone;
    if (measured_m > depth_m + kBehindM && !IsBesideSlope(point, depth_m, measured_m)) {
      return Sight::kLookedThrough;
    }
    return IsBesideSlope(point, depth_m, measured_m) ? Sight::kSeen : Sight::kNone;
  }

 private:
  static constexpr float kMinDepthM = 0.3F;

  // True if the measured depth is the point's own, within the size of a pixel.
  bool IsBesideSlope(const SurfacePoint& point, float depth_m, float measured_m) const {
    const Eigen::Vector3f to_eye = (eye_world_ - point.position_world).normalized();
    const float cosine = to_eye.dot(point.normal_world);
    if (cosine < kMinCosine) return false;
    const float slope = std::sqrt(1.0F - cosine * cosine) / cosine;
    return std::abs(measured_m - depth_m) <=
           kSameDepthM + slope * depth_m / static_cast<float>(view_.camera.fx);
  }

  const DepthView& view_;
  Eigen::Isometry3f T_camera_world_;
  Eigen::Vector3f eye_world_;
  float max_depth_m_;
  float max_range_m_;  // Beyond it there is no return and no evidence.
};

// True if a part of a place may be in view: tests its bounding sphere against the range and the
// camera's plane.
bool MayBeInView(const SurveyedPlace& place, const DepthView& view, double max_depth_m) {
  const double radius_m = 0.5 * place.box_world.diagonal().norm();
  const double depth_m = (view.T_world_camera.inverse() * place.box_world.center()).z();
  return depth_m > -radius_m && depth_m < max_depth_m + radius_m;
}

void LookAtPlace(const Viewer& viewer,
                 std::size_t sequence,
                 std::size_t frame,
                 double point_area_m2,
                 SurveyedPlace* place) {
  const std::uint32_t bit = 1U << sequence;
  std::size_t told = 0;
  for (std::size_t i = 0; i < place->points.size(); ++i) {
    const Sight sight = viewer.Look(place->points[i]);
    if (sight == Sight::kNone) continue;
    // A depth measured at a point of an absent object belongs to another object at the same place.
    const bool is_seen = sight == Sight::kSeen && place->StandsIn(sequence);
    if (is_seen) place->seen_in[i] |= bit;
    if (sight == Sight::kLookedThrough) place->looked_through_in[i] |= bit;
    if (is_seen || sight == Sight::kLookedThrough) ++told;
  }
  if (static_cast<double>(told) * point_area_m2 >= kInViewM2) {
    place->frames_in_view.push_back(frame);
  }
}

/// The surface of the objects that move during one sequence.
class Movers {
 public:
  Movers(const Scene& scene, const SurveyOptions& options) : spacing_m_(options.spacing_m) {
    for (const SceneObject& object : scene.objects()) {
      if (!object.moves()) continue;
      movers_.push_back(
          {&object,
           SampleFacets(FacetsOf(object.shape, Eigen::Isometry3d::Identity()), spacing_m_)});
    }
  }

  // Adds the observed surface points at `time_s` to `swept`, unless their cell is in `met`.
  void Look(const Viewer& viewer,
            double time_s,
            std::unordered_set<VoxelIndex>* met,
            std::vector<SurfacePoint>* swept) const {
    for (const auto& [object, points] : movers_) {
      const Eigen::Isometry3f T_world_object = object->PoseAt(time_s).cast<float>();
      for (const SurfacePoint& known : points) {
        const SurfacePoint point = {T_world_object * known.position_world,
                                    T_world_object.linear() * known.normal_world};
        if (viewer.Look(point) == Sight::kSeen &&
            met->insert(VoxelAt(point.position_world, spacing_m_)).second) {
          swept->push_back(point);
        }
      }
    }
  }

 private:
  struct Mover {
    const SceneObject* object;
    std::vector<SurfacePoint> points_object;
  };

  double spacing_m_;
  std::vector<Mover> movers_;
};

// The depth of a ray without a hit is infinite.
void FillDepth(const SurfaceImage& surfaces, Image<float>* depth_m) {
  const float* inverse_depth = surfaces.pixels.inverse_depth_per_m.data();
  for (std::size_t i = 0; i < depth_m->size(); ++i) {
    depth_m->data()[i] = 1.0F / inverse_depth[i];
  }
}

SurveyedPlace MakePlace(const SceneObject& object,
                        double spacing_m,
                        const Eigen::AlignedBox3d& reach_world) {
  SurveyedPlace place;
  place.object = object.id;
  place.name = object.name;
  place.group = object.group;
  place.semantic_class = object.semantic_class;
  place.T_world_object = object.T_world_object;
  place.points = SampleFacets(FacetsOf(object.shape, object.T_world_object), spacing_m);
  for (const SurfacePoint& point : place.points) {
    place.box_world.extend(point.position_world.cast<double>());
  }
  std::erase_if(place.points, [&reach_world](const SurfacePoint& point) {
    return !reach_world.contains(point.position_world.cast<double>());
  });
  place.seen_in.resize(place.points.size());
  place.looked_through_in.resize(place.points.size());
  return place;
}

// Returns the region within range of any camera pose of the route.
Eigen::AlignedBox3d ReachOf(const Simulation& simulation, double max_depth_m) {
  Eigen::AlignedBox3d reach_world;
  for (std::size_t frame = 0; frame < simulation.frame_count(); ++frame) {
    reach_world.extend(simulation.TruePose(frame).translation());
  }
  // The distance of a corner pixel exceeds its depth.
  const Eigen::Vector3d margin_m = Eigen::Vector3d::Constant(1.5 * max_depth_m);
  return {reach_world.min() - margin_m, reach_world.max() + margin_m};
}

std::vector<SurveyedPlace> ListPlaces(const Simulation& simulation, const SurveyOptions& options) {
  const Route& route = simulation.route();
  const Eigen::AlignedBox3d reach_world = ReachOf(simulation, options.max_depth_m);
  std::vector<SurveyedPlace> places;
  for (std::size_t sequence = 0; sequence < route.sequences.size(); ++sequence) {
    for (const SceneObject& object : route.sequences[sequence].scene.objects()) {
      if (object.moves()) continue;
      auto place = std::find_if(places.begin(), places.end(), [&](const SurveyedPlace& known) {
        return known.object == object.id &&
               known.T_world_object.isApprox(object.T_world_object, kSamePlaceM);
      });
      if (place == places.end()) {
        place = places.insert(places.end(), MakePlace(object, options.spacing_m, reach_world));
      }
      place->stands_in |= 1U << sequence;
    }
  }
  return places;
}

std::vector<std::size_t> FirstFrames(const Simulation& simulation) {
  std::vector<std::size_t> first_frames;
  for (std::size_t frame = 0; frame < simulation.frame_count(); ++frame) {
    if (simulation.SequenceOf(frame) == first_frames.size()) first_frames.push_back(frame);
  }
  first_frames.push_back(simulation.frame_count());
  return first_frames;
}

}  // namespace

RouteSurvey SurveyRoute(const Simulation& simulation, const SurveyOptions& options) {
  const Route& route = simulation.route();
  assert(route.sequences.size() <= kMaxSurveyedSequences);
  RouteSurvey survey{.sequence_count = route.sequences.size(),
                     .first_frames = FirstFrames(simulation),
                     .point_area_m2 = options.spacing_m * options.spacing_m,
                     .places = ListPlaces(simulation, options),
                     .last_observed = {options.voxel_size_m, options.max_depth_m}};
  std::unordered_set<VoxelIndex> swept_cells;
  DepthView view;
  view.camera = route.camera;
  view.depth_m = Image<float>(route.camera.width_px, route.camera.height_px);
  for (std::size_t sequence = 0; sequence < survey.sequence_count; ++sequence) {
    const RouteSequence& drive = route.sequences[sequence];
    Renderer renderer(&drive.scene, route.camera, SensorModel::Ideal());
    const Movers movers(drive.scene, options);
    const std::size_t first = survey.first_frames[sequence];
    for (std::size_t frame = first; frame < survey.first_frames[sequence + 1]; ++frame) {
      const auto step = static_cast<double>((frame - first) * simulation.options().stride);
      const double time_s = step * drive.trajectory.frame_period_s;
      view.T_world_camera = simulation.TruePose(frame);
      FillDepth(renderer.RenderSurfaces(view.T_world_camera, time_s), &view.depth_m);
      if (sequence == survey.last_sequence()) survey.last_observed.AddView(view);
      const Viewer viewer(view, options);
      movers.Look(viewer, time_s, &swept_cells, &survey.swept);
      for (SurveyedPlace& place : survey.places) {
        if (!MayBeInView(place, view, options.max_depth_m)) continue;
        LookAtPlace(viewer, sequence, frame, survey.point_area_m2, &place);
      }
    }
  }
  return survey;
}

}  // namespace steadymap
