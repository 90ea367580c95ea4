#pragma once

#include <cstddef>
#include <cstdint>

#include "core/map/stationarity.h"
#include "core/objects/session_parts.h"

namespace steadymap {

/// The constants of `DecideSession`.
struct SessionIdentityParameters {
  /// Of `parts.shares`: what disagrees with a known shape is negligible, and what is known of it is
  /// substantial in its place, a majority elsewhere; there, most of what is known agrees within the
  /// error of two looks, and its area is no negligible share of the known one. A move is clear if
  /// without it, the best explanation of all changes agrees by more than a negligible share less.
  SessionPartParameters parts;
  /// Stationarity of a new object.
  double initial_stationarity = 0.67;
  /// Of the pose claimed by the robot, in the alignment of a session; each known object has one.
  double claim_votes = 1.5;
  /// What is displaced by more was moved: no robot is off by so much, metres.
  double max_session_offset_m = 0.15;
  /// Displacement at which a known object has lost half of its vote, metres, at least half a voxel.
  double vote_scale_m = 0.02;
  /// An object that is displaced by no more than this, the largest error of a registered frame,
  /// stands where it stood, metres.
  double max_displacement_m = 0.03;
  /// The same in standard deviations of the displacements of all objects, which tell the error of
  /// the poses.
  double max_pose_sigmas = 3.0;
  /// Smallest looked-at area that decides, square metres; of a smaller object, a substantial share
  /// of its evidence cells.
  double min_looked_at_area_m2 = 0.04;
  /// Fewest evidence cells of a part that is gone.
  std::size_t min_part_cells = 25;
  /// What was seen by so much later than the end of a session is of a later one, seconds.
  double max_pause_s = 10.0;
  /// A sensor that finds an object gone so soon after another one saw it contradicts it, seconds:
  /// so soon a thing may leave, but does not come back and leave again.
  double contradiction_window_s = 300.0;
  StationarityParameters belief;

  friend bool operator==(const SessionIdentityParameters&,
                         const SessionIdentityParameters&) = default;
};

}  // namespace steadymap
