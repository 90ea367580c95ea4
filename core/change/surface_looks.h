#pragma once

#include <algorithm>
#include <cstddef>

#include "core/association/sample_grid.h"
#include "core/change/min_depth_grid.h"
#include "core/integration/semantic_cloud.h"
#include "core/map/object_evidence.h"
#include "core/types/timestamp.h"
#include "core/working/tracked_object.h"

namespace steadymap {

/// One frame, for looks at the surface of objects.
struct LookedAtFrame {
  const SemanticCloud& cloud;
  const SampleGrid& samples;
  const MinDepthGrid& tiles;
};

/// When a measured depth agrees with a mapped surface.
struct LookParameters {
  double max_sigmas = 3.0;     ///< Of the difference between the measured and the mapped depth.
  double pose_sigma_m = 0.01;  ///< Standard deviation of the pose of a frame, metres.
  /// Surface at a flatter angle to the ray says little: noise and pose errors move the ray off it.
  double min_facing_cosine = 0.25;
  /// Between the normals of a measured and a mapped surface: at a larger angle, they are two.
  double min_normal_cosine = 0.7;
  /// A class may be wrong: a look at another class counts as absence only if the surface does not
  /// agree either, or if the frame has labels and this is true.
  bool labels_decide = true;
  /// Looks of one surface within this time count once, seconds, so that evidence does not depend on
  /// the frame rate.
  double min_interval_s = 0.15;
  /// So many looks confirm each other; what one alone shows may be noise. Also the largest
  /// magnitude of a score, so that as many looks take it back.
  int confirming_looks = 2;
  /// A whole object is gone if of its evidence cells at least so many, no negligible share of all,
  /// and most of those that were looked at are gone.
  std::size_t min_gone_cells = 3;
  double negligible_share = 0.15;
  double whole_gone_share = 0.7;

  friend bool operator==(const LookParameters&, const LookParameters&) = default;
};

/// Returns how far a surface in place may be measured off it at a depth, metres.
double LookLimitM(const LookParameters& parameters,
                  const SemanticCloud& cloud,
                  const VoxelScale& scale,
                  float depth_m);

/// The number of evidence cells of an object by the balance of their looks.
struct LookCount {
  std::size_t cells = 0;  ///< All of them, looked at or not.
  std::size_t found = 0;  ///< More looks found surface than not.
  std::size_t gone = 0;   ///< More looks found none, or surface of another class.

  std::size_t looked_at() const { return found + gone; }

  /// True if at least as much was found gone as in place.
  bool is_doubtful() const { return gone > 0 && gone >= found; }

  /// Returns how many cells tell of the whole object: `min_cells`, or of a small object half of its
  /// cells, since a camera sees no more of them at once; at least one.
  std::size_t DecidingCells(std::size_t min_cells) const {
    return std::min(min_cells, std::max<std::size_t>(cells / 2, 1));
  }
};

/// Adds one look of a frame at each evidence cell of an object that faces the camera and is not
/// occluded: one up where surface of its class is measured, one down where there is none. Scores
/// are limited on either side. If the frame shows that a whole object is gone, the positive scores
/// of the cells that it does not show go one down too: of an object of the session, or if looks of
/// the session have found the cells that are gone now. Returns false if no cell was looked at.
/// `now` is the capture time of the frame.
bool AddLook(const LookedAtFrame& frame,
             const LookParameters& parameters,
             const VoxelScale& scale,
             Timestamp now,
             const TrackedObject& object,
             ObjectEvidence* evidence);

/// True if an object of a session, which more than one frame has seen, is gone as a whole by the
/// looks at it from `pause_s` seconds on after the last of these frames.
bool HasLeft(const LookParameters& parameters, double pause_s, const TrackedObject& object);

/// Counts the evidence cells of an object's surface by the balance of their looks, of those that a
/// frame has looked at after `since`.
LookCount CountLooks(const TrackedObject& object, Timestamp since = Timestamp::Earliest());

}  // namespace steadymap
