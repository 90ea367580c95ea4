#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "client/bench/evaluation/truth/observed_space.h"
#include "client/bench/evaluation/truth/surface_points.h"
#include "client/bench/simulator/simulation.h"

/// The truth about a simulated route, restricted to the parts that the robot could observe.
namespace steadymap {

/// An object at one place, in one or more sequences of a route. A moved object has one entry per
/// place.
struct SurveyedPlace {
  std::uint16_t object = 0;                             ///< `SceneObject::id`.
  std::string name;                                     ///< `SceneObject::name`.
  std::string group;                                    ///< `SceneObject::group`.
  SceneClass semantic_class = SceneClass::kBackground;  ///< `SceneObject::semantic_class`.
  Eigen::Isometry3d T_world_object = Eigen::Isometry3d::Identity();
  Eigen::AlignedBox3d box_world;     ///< Around its whole surface.
  std::vector<SurfacePoint> points;  ///< Its surface within sensor range.
  std::uint32_t stands_in = 0;       ///< Bit k: it is here in sequence k.
  /// One word per point. Bit k: sequence k observed it.
  std::vector<std::uint32_t> seen_in;
  /// One word per point. Bit k: sequence k measured depth behind it. Without a surface behind there
  /// is no return, and so no evidence of absence.
  std::vector<std::uint32_t> looked_through_in;
  /// Frames that observed it or measured depth behind it, ascending.
  std::vector<std::size_t> frames_in_view;

  bool StandsIn(std::size_t sequence) const { return ((stands_in >> sequence) & 1U) != 0; }
};

/// Everything that the robot could observe with a perfect camera at its true poses.
struct RouteSurvey {
  std::size_t sequence_count = 0;
  std::vector<std::size_t> first_frames;  ///< Of each sequence, then the number of frames.
  double point_area_m2 = 0.0;             ///< Surface represented by one point.
  std::vector<SurveyedPlace> places;      ///< Of all objects at rest during sequences.
  /// Surface of moving objects at every observed position; one point per cell of the spacing.
  std::vector<SurfacePoint> swept{};
  /// Voxels that the rays of the last sequence hit or passed through, including rays without a
  /// return.
  ObservedSpace last_observed;

  std::size_t last_sequence() const { return sequence_count - 1; }
};

/// Options of a survey.
struct SurveyOptions {
  double voxel_size_m = 0.2;  ///< Of `RouteSurvey::last_observed`.
  double spacing_m = 0.025;   ///< Of the points.
  double max_depth_m = 3.0;   ///< Of the maps: they ignore farther surface.
};

/// Largest number of sequences of a survey.
inline constexpr std::size_t kMaxSurveyedSequences = 32;

/// Plays the route of `simulation` with a perfect camera. The route must have at most
/// `kMaxSurveyedSequences` sequences (asserted). Cost: about 4 ms per frame.
RouteSurvey SurveyRoute(const Simulation& simulation, const SurveyOptions& options);

}  // namespace steadymap
