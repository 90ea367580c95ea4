#pragma once

#include <cstdint>

#include "core/objects/scene_division.h"
#include "core/objects/surface_overlap.h"
#include "core/objects/surface_shares.h"
#include "core/working/tracked_object.h"
#include "core/working/working_map.h"

namespace steadymap {

/// The constants of `CompleteSessionObjects`.
struct SessionPartParameters {
  /// Fewest frames and smallest surface, square metres, of an object.
  std::uint64_t min_frames = 2;
  double min_area_m2 = 0.004;
  /// Fewest frames of an object, or of background, that others contradict: fewer have a wrong
  /// label.
  std::uint64_t min_doubted_frames = 5;
  /// Fewest points or cells of a surface that count as evidence: so many span a plane.
  std::size_t min_points = 3;
  SurfaceMatchParameters surface;
  /// Two surfaces are of one object if they have a substantial share of the smaller one in common,
  /// or if a substantial share of the frames shows them connected: parts of one object are hidden
  /// by others or seen at flat angles often, but two objects are rarely seen as one.
  SurfaceShares shares;
  /// An object with less than this share of the surface of another one of its class beside it is a
  /// fragment of it.
  double fragment_share = 0.1;
  /// An object goes on behind what hides it for no more than this share of its width. A fragment is
  /// closer to its object than this share of the object's length.
  double max_hidden_gap_share = 0.5;
  /// A leg is narrower than this, metres, and than `scene.max_leg_share` of its length.
  double max_leg_width_m = 0.25;
  /// A leg belongs to an object that is closer than this, metres, and than the length of the leg
  /// and that of the shorter of the two.
  double max_leg_gap_m = 1.0;
  /// What is farther from a leg bears neither of its ends, nor continues it, metres.
  double max_gap_m = 0.3;
  /// The border of a region that changed tends to lie at a concave edge, where a thing stands on
  /// another: a right angle inwards counts like so long a way along the surface, metres.
  double concave_cost_m = 0.5;
  /// So far behind a surface, space that was open shows that the surface is new, metres.
  double behind_m = 0.08;
  SceneDivisionParameters scene;

  friend bool operator==(const SessionPartParameters&, const SessionPartParameters&) = default;
};

/// Makes whole objects of what the session of a source has fused (status `kTentative`): divides
/// surface without labels, joins parts that most frames show connected, deletes fragments and wrong
/// labels.
void CompleteSessionObjects(const SessionPartParameters& parameters,
                            const SensorName& source,
                            WorkingMap* map);

/// Adds the surface of one object of the session to another one and deletes it.
void JoinSessionObjects(TrackedObject* object, TrackedObject* into, WorkingMap* map);

/// Adds the voxels of an object that `into` does not have.
void AddVoxels(const TrackedObject& from, WorkingMap* map, TrackedObject* into);

/// Deletes the surface of an object in cells that most looks found gone, or of another class.
void CutGoneCells(TrackedObject* object, WorkingMap* map);

/// True if an object has too little surface, or no shape: that of a single voxel. Without a
/// given extent, the surface counts with its weight.
bool IsTooSmall(const TrackedObject& object, const SessionPartParameters& parameters);

bool IsOfOneClass(const TrackedObject& a, const TrackedObject& b);

/// True if an object is so much smaller than one of its class beside it that it is a part of it.
/// False without labels: `DivideScene` has told what stands on what.
bool IsFragmentOf(const TrackedObject& object,
                  const TrackedObject& other,
                  const SessionPartParameters& parameters);

/// True if an object is a part of another one of its class: a fragment of it, inside its cuboid, or
/// near it with nothing seen of what is between them. False without labels.
bool IsPartOf(const TrackedObject& object,
              const TrackedObject& other,
              const SessionPartParameters& parameters,
              const WorkingMap& map);

/// True if points of the surface of `a` are in contact with the surface of `b`.
bool AreInContact(const TrackedObject& a,
                  const TrackedObject& b,
                  const SessionPartParameters& parameters,
                  const VoxelScale& scale);

}  // namespace steadymap
