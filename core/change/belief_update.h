#pragma once

#include "core/change/visibility.h"
#include "core/map/map_object.h"
#include "core/map/object_surface.h"
#include "core/types/map_config.h"
#include "core/types/timestamp.h"
#include "core/working/tracked_object.h"

namespace steadymap {

/// How much evidence a belief takes to change.
struct BeliefUpdateParameters {
  StationarityParameters stationarity;
  /// Share of an object's judged cells that must be gone to speak against it (theta_vis).
  double absent_share = 0.35;
  /// Below this share they speak for it; in between they say nothing.
  double present_share = 0.20;
  /// Cells to be judged before the belief is updated.
  double cells_per_update = 15.0;
  /// An object that was not found for so long may have been moved meanwhile, seconds. Classes that
  /// stay gather certainty fast; what was learnt of them on an earlier visit counts no more than
  /// `revisit_evidence`, to which alpha + beta is held until the object is found again.
  double visit_gap_s = 20.0;
  double revisit_evidence = 3.0;
};

/// How much of an object that was found on a visit must be contradicted for it to be gone on the
/// same visit: the same few cells, missed again and again, say little of the rest.
struct ContradictionParameters {
  /// So many cells,
  std::size_t cells = 10;
  /// or this share of a smaller object.
  double share = 0.1;
  /// A visit takes that long, seconds.
  double visit_s = 60.0;
  /// On any visit, an object of which so many times more cells were found in the last `found_s`
  /// seconds stands: from nearby, little more than a missed edge may be in view for a while.
  double found_ratio = 4.0;
  double found_s = 20.0;
  /// Not so when it is believed less than this: what was found may be of what took its place.
  double least_stationarity = 0.2;
};

/// What the class of a thing says about its staying: unlisted classes stay.
StationarityPrior PriorOf(const MapConfig& config, ClassId class_id);

/// Adds what a frame taken at `now` says about each part of an object's surface to what is known.
/// Surface found present without a measure of its change counts as unchanged. What was found and
/// not counted yet is forgotten if the last of it was longer ago than `visit_gap_s`: it may have
/// gone since.
void AddEvidence(const ObjectVerdict& verdict,
                 const ObjectSurface& surface,
                 Timestamp now,
                 double visit_gap_s,
                 ObjectEvidence* evidence);

/// Turns the evidence since the last update into one measurement and updates the belief with it, if
/// there is enough of it (core/README.md#evidence); whether there was. Evidence for the object
/// measures the mean change of the surface found, evidence against it the greatest change there is.
bool UpdateBelief(StationarityPrior prior,
                  Timestamp now,
                  const BeliefUpdateParameters& parameters,
                  ObjectState* object);

/// Whether enough speaks against an object for its belief to decide: of what was found on the visit
/// of `now`, enough cells are missed by the frame, or were missed oftener than found; and not too
/// many were found a moment ago.
bool IsContradicted(const ObjectVerdict& verdict,
                    Timestamp now,
                    const ContradictionParameters& parameters,
                    const TrackedObject& object);

}  // namespace steadymap
