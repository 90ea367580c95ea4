#pragma once

#include <cstddef>
#include <deque>
#include <vector>

#include <Eigen/Geometry>

#include "core/objects/session_parameters.h"
#include "core/objects/standing.h"
#include "core/working/tracked_object.h"

/// What is known of the objects of a session, and of the known ones, while the session is decided.
namespace steadymap {

/// An object that was known before the session.
struct KnownObject {
  TrackedObject* object = nullptr;
  std::size_t index = 0;
  Standing standing = Standing::kUnknown;
  bool is_taken = false;  ///< By an object of the session.
  /// The object of which it was a part until the session found this part gone; 0: none.
  ObjectId part_of;
};

/// An object of the session.
struct SeenObject {
  TrackedObject* object = nullptr;
  std::size_t index = 0;
  bool is_new_region = false;  ///< Was not there when a known object beside it was seen.
  bool has_left = false;       ///< Later frames of the session have found it gone.
  double pose_error_m = 0.0;   ///< What is displaced by no more may stand where it stood.
  /// Share of its surface that later sessions have looked through; 0 unless the session is of the
  /// past.
  double removed_share = 0.0;
  bool is_decided = false;
};

/// An object of the session on the surface of a known one.
struct PlaceMatch {
  SeenObject* seen = nullptr;
  KnownObject* known = nullptr;
  double displacement_m = 0.0;
  double fit = 0.0;           ///< Share of the surface that agrees.
  bool fits_at_rest = false;  ///< See `IsDisplaced`: the displacement tells nothing.
  double close_share = 1.0;   ///< Share of both surfaces that agrees within the error of two looks.
};

/// The objects of one decision.
struct SessionObjects {
  std::deque<SeenObject> seen;  ///< Not moved in memory when it grows.
  std::deque<KnownObject> known;
  /// In place, but much of the known object is gone, or a move may explain the surface better.
  std::vector<PlaceMatch> doubted;
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();  ///< Of the session onto the map.

  void AddSeen(TrackedObject* object, bool has_left) {
    seen.push_back({object, seen.size(), /*is_new_region=*/false, has_left});
  }

  /// Adds a new region of `whole`, which has the pose error of the rest and left with it.
  void AddRegion(TrackedObject* region, const SeenObject& whole) {
    seen.push_back(
        {region, seen.size(), /*is_new_region=*/true, whole.has_left, whole.pose_error_m});
  }

  void AddKnown(TrackedObject* object, Standing standing) {
    known.push_back({object, known.size(), standing, /*is_taken=*/false, ObjectId()});
  }

  /// Adds a part of a known object that is gone.
  void AddGonePart(TrackedObject* part, const TrackedObject& whole) {
    known.push_back({part, known.size(), Standing::kGone, /*is_taken=*/false, whole.id()});
  }
};

/// Returns the share of the looked-at surface of a known object that is gone; 0 if the looks were
/// from wrong poses.
double DoubtOf(const TrackedObject& known,
               const SessionObjects& objects,
               const SessionIdentityParameters& parameters);

/// True if an object of the session was last seen before a known one was removed.
bool IsOlderThanRemoval(const SeenObject& seen, const KnownObject& known);

/// True if an object of the session was last seen before a present one: it may show where that one
/// stood before.
bool IsOlderThanLastLook(const SeenObject& seen, const KnownObject& known);

}  // namespace steadymap
