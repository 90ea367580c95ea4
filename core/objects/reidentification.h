#pragma once

#include <limits>
#include <vector>

#include "core/change/yaw_change.h"
#include "core/map/stationarity.h"
#include "core/working/tracked_object.h"

/// Tells a thing that comes back from one that is new.
namespace steadymap {

/// How little of a thing is a piece of another one.
struct PieceParameters {
  /// The second longest side of its cuboid is no longer than that, and that of the other thing is,
  /// metres.
  double size_m = 0.0;
  /// It lies no further than that from the cuboid of the other thing, metres,
  double distance_m = 0.0;
  /// which came at most so long before it, seconds.
  double apart_s = 0.0;
};

/// How alike is the same thing.
struct ReidentificationParameters {
  /// A new object is an archived one, back in its place, if so much of the new surface lies where
  /// the archived object knows anything,
  double return_known_share = 0.8;
  /// The same for classes that stay: of a wall one corner tells enough.
  double return_known_share_of_walls = 0.3;
  /// and so much of that lies on the archived surface;
  double return_fit_share = 0.9;
  /// of what is seen of a wall beside what hides it, edges are a greater part.
  double return_fit_share_of_walls = 0.8;
  /// What fits but is turned is not the same as it stood.
  YawChangeParameters turn;
  /// The less that is asked of walls holds for those that were gone for so long: what is found gone
  /// and found again on one visit was moved a little, seconds.
  double wall_absence_s = 20.0;
  /// What was found gone on this very visit is back only if so much of the surface that was missed
  /// is there again: otherwise it is a part that stayed, and the rest would come back with it.
  double refound_share = 0.5;
  /// A new object is what stayed of one found gone on this visit, if so much of the new surface
  /// lies where that knows anything, and as much of that on its surface as of one that returns.
  double stayed_known_share = 0.5;
  /// A hand's breadth of a class that stays, close to more of it, was hidden until now: nobody
  /// builds so little of a wall or a rack. What is narrower than cells of free space may stand in
  /// one that was looked through.
  PieceParameters fixture = {
      .size_m = 0.25, .distance_m = 0.5, .apart_s = std::numeric_limits<double>::infinity()};
  /// Of other things, legs and edges are pieces of what came on the same visit.
  PieceParameters thing = {.size_m = 0.15, .distance_m = 0.1, .apart_s = 20.0};
  /// An archived object of a class that stays is part of a new one, if so much of its surface lies
  /// where the new one knows anything, and as much of that on its surface as of a wall that
  /// returns.
  double part_known_share = 0.15;
  /// A visit takes that long, seconds.
  double same_visit_s = 60.0;
  /// What of a class that stays was found gone on the same visit as a neighbour, and no further
  /// from it than that, comes back with it: a wall is taken down and put up as a whole, metres.
  double neighbour_distance_m = 0.8;
};

/// How the surface of one object lies with another one.
struct SurfaceOverlap {
  double known_share = 0.0;  ///< Share of the points in what the other has observed.
  double fit_share = 0.0;    ///< Of those, the share on its surface, facing the same way.
  YawChangeSum turn;         ///< Of those that fit.
};

/// Compares the surface of `object`, moved by `T_other_object`, with the volume of `other`. A point
/// lies on the surface within one and a half voxels. Zeros for an object without surface.
SurfaceOverlap CompareSurfaces(const TrackedObject& object,
                               const TrackedObject& other,
                               const Eigen::Isometry3d& T_other_object,
                               const VoxelScale& scale);

/// The archived candidate of the same class (none that is being forgotten) that best explains
/// `object` where it stood itself; null if none does. Of equals the last, so candidates come by
/// rising id; those whose bounds do not meet the object's need not be among them.
TrackedObject* FindReturned(const TrackedObject& object,
                            const VoxelScale& scale,
                            StationarityPrior prior,
                            const ReidentificationParameters& parameters,
                            const std::vector<TrackedObject*>& candidates);

/// The archived candidate of the same class that was found gone on this visit although `object` is
/// a part of it that stayed; null if there is none. Of equals the last.
TrackedObject* FindWhole(const TrackedObject& object,
                         const VoxelScale& scale,
                         const ReidentificationParameters& parameters,
                         const std::vector<TrackedObject*>& candidates);

/// Whether `object` may turn out to be one thing with `other`, which the map shows: of its class,
/// near enough, and not much older.
bool MayBeOneThing(const TrackedObject& object,
                   const TrackedObject& other,
                   const PieceParameters& parameters);

/// The present candidate of the same class that `object` is a piece of: the nearest that is near
/// enough, if the object is small enough; null if there is none. Of equals the first. Candidates
/// further away need not be among them.
TrackedObject* FindHost(const TrackedObject& object,
                        const PieceParameters& parameters,
                        const std::vector<TrackedObject*>& candidates);

/// The archived candidates of the same class that were found gone together with the archived
/// `object`, directly or one by one; without it. Candidates may be far away, since a wall is long.
std::vector<TrackedObject*> FindGoneWith(const TrackedObject& object,
                                         const ReidentificationParameters& parameters,
                                         const std::vector<TrackedObject*>& candidates);

/// The archived candidates of the same class whose surface turns out to be that of `object`; those
/// whose bounds do not meet the object's need not be among them.
std::vector<TrackedObject*> FindReturnedParts(const TrackedObject& object,
                                              const VoxelScale& scale,
                                              const ReidentificationParameters& parameters,
                                              const std::vector<TrackedObject*>& candidates);

}  // namespace steadymap
