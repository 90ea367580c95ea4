#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "client/bench/evaluation/truth/observed_space.h"
#include "client/bench/evaluation/truth/surface_points.h"
#include "client/bench/simulator/simulation.h"

/// The truth about a simulated route, and what of it the robot was in a position to find out.
namespace steadymap {

/// A thing at one place, which it holds in one or more sequences of a route. A thing that is moved
/// has one for each of its places.
struct SurveyedPlace {
  std::uint16_t object = 0;                             ///< `SceneObject::id`.
  std::string name;                                     ///< `SceneObject::name`.
  std::string group;                                    ///< `SceneObject::group`.
  SceneClass semantic_class = SceneClass::kBackground;  ///< `SceneObject::semantic_class`.
  Eigen::Isometry3d T_world_object = Eigen::Isometry3d::Identity();
  Eigen::AlignedBox3d box_world;     ///< Around its whole surface.
  std::vector<SurfacePoint> points;  ///< Its surface within the robot's reach.
  std::uint32_t stands_in = 0;       ///< Bit k: it stands here in sequence k.
  /// A word a point. Bit k: sequence k saw it.
  std::vector<std::uint32_t> seen_in;
  /// A word a point. Bit k: sequence k measured depth behind it. Where there is nothing behind
  /// there is no return, and so no evidence that it is gone.
  std::vector<std::uint32_t> looked_through_in;
  std::vector<std::size_t> frames_in_view;  ///< Frames that saw it or looked through it, rising.

  bool StandsIn(std::size_t sequence) const { return ((stands_in >> sequence) & 1U) != 0; }
};

/// What a route's robot could find out with a perfect camera at its true poses.
struct RouteSurvey {
  std::size_t sequence_count = 0;
  std::vector<std::size_t> first_frames;  ///< Of each sequence, then the number of frames.
  double point_area_m2 = 0.0;             ///< Surface that one point stands for.
  std::vector<SurveyedPlace> places;      ///< Of all things that stand still during sequences.
  /// Surface of the things that move, wherever it was seen; one point a cell of the spacing.
  std::vector<SurfacePoint> swept{};
  /// What the rays of the last sequence met or passed through, those without a return included:
  /// they met nothing.
  ObservedSpace last_observed;

  std::size_t last_sequence() const { return sequence_count - 1; }
};

/// How a route is surveyed.
struct SurveyOptions {
  double voxel_size_m = 0.2;  ///< Of `RouteSurvey::last_observed`.
  double spacing_m = 0.025;   ///< Of the points.
  double max_depth_m = 3.0;   ///< Of the maps: farther surface tells them nothing.
};

/// The number of sequences that a survey can hold.
inline constexpr std::size_t kMaxSurveyedSequences = 32;

/// Drives the route of `simulation` with a perfect camera. The route must have at most
/// `kMaxSurveyedSequences` sequences (asserted). Cost: about 4 ms a frame.
RouteSurvey SurveyRoute(const Simulation& simulation, const SurveyOptions& options);

}  // namespace steadymap
