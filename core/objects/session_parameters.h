#pragma once

#include <cstddef>
#include <cstdint>

#include "core/map/stationarity.h"
#include "core/objects/session_parts.h"

namespace steadymap {

/// The constants of `DecideSession`.
struct SessionIdentityParameters {
  SessionPartParameters parts;
  /// Stationarity of a new object.
  double initial_stationarity = 0.67;
  /// Of the pose claimed by the robot, in the alignment of a session; each known object has one.
  double claim_votes = 1.5;
  /// What is displaced by more was moved: no robot is off by so much, metres.
  double max_session_offset_m = 0.15;
  /// Displacement at which a known object has lost half of its vote, metres, at least half a voxel.
  double vote_scale_m = 0.02;
  /// An object that is displaced by no more than this stands where it stood, metres.
  double max_displacement_m = 0.03;
  /// The same in standard deviations of the displacements of all objects, which tell the error of
  /// the poses.
  double max_pose_sigmas = 3.0;
  /// Share of the surface that may disagree with a known shape, and that must be known of it.
  double max_dissimilarity = 0.2;
  double min_known_share = 0.3;
  /// Share that must be known to know a moved or returned object by its shape, and share of what is
  /// known of a shape that must agree within the error of two looks, averaged over both shapes.
  double min_shape_known_share = 0.5;
  double min_shape_close_share = 0.7;
  /// Share of the looked-at surface that must be gone of an object that is gone.
  double gone_share = 0.5;
  /// A smaller share of a surface tells nothing: errors of looks and of registration make it. Of an
  /// object in whose place another one is, or that no later session has seen, so much must be gone,
  double negligible_share = 0.15;
  /// or so much of that object's surface must be known of the shape, if it was displaced by less
  /// than can be seen through.
  double min_displaced_known_share = 0.6;
  /// A move is clear if without it, the best explanation of all changes agrees this much less.
  double rival_margin = 0.12;
  /// Smallest surface of a moved object, as a share of the surface that was known of it.
  double min_moved_area_share = 0.25;
  /// Fewest looked-at evidence cells that decide, and smallest looked-at area, square metres; of a
  /// smaller object, `min_known_share` of its cells.
  std::size_t min_looked_at_cells = 4;
  double min_looked_at_area_m2 = 0.04;
  /// Fewest evidence cells, and smallest share of the looked-at ones, of a part that is gone.
  std::size_t min_part_cells = 25;
  double min_part_share = 0.1;
  /// What was seen by so much later than the end of a session is of a later one, seconds.
  double max_pause_s = 10.0;
  /// A sensor that finds an object gone so soon after another one saw it contradicts it, seconds:
  /// so soon a thing may leave, but does not come back and leave again.
  double contradiction_window_s = 300.0;
  /// Share of the smaller of two cuboids in which only one of both can be.
  double max_overlap_share = 0.3;
  StationarityParameters belief;

  friend bool operator==(const SessionIdentityParameters&,
                         const SessionIdentityParameters&) = default;
};

}  // namespace steadymap
