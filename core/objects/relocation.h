#pragma once

#include <cstdint>
#include <vector>

#include "core/association/association.h"
#include "core/working/working_map.h"

/// Finds out that a thing which is new in one place is one that left another.
namespace steadymap {

/// When two objects are one thing that moved.
struct RelocationParameters {
  /// Frames that must have seen the thing in its new place: before, its shape is not known.
  std::uint64_t views = 10;
  /// Sides of things that may be mistaken for each other differ by no more than this, metres: boxes
  /// around what was seen in passing are that wrong.
  double lookalike_tolerance_m = 0.3;
  /// Those of the same thing by no more than this, ...
  double size_tolerance_m = 0.2;
  /// ... and its height and the longer side of its base by no more than this share of the longer
  /// one (how deep it is, a front alone does not show), ...
  double size_tolerance_share = 0.2;
  /// ... but they always may by as much as this, metres.
  double least_size_tolerance_m = 0.1;

  /// A thing that vanishes no further than this from a new one that is alike was pushed aside,
  /// metres; it need not have been given up yet, but ...
  double pushed_distance_m = 0.9;
  /// ... so many cells of the old place must be found gone, and none found there again.
  double pushed_absent_cells = 8.0;
  /// It stays on its board: heights of both middles differ by no more than this, metres.
  double pushed_height_m = 0.2;
  /// A thing of which more than this share was found a moment ago stands where it stood: an edge
  /// alone is missed. Where the new place overlaps the old one, it may be the new thing that was
  /// found.
  double pushed_found_share = 0.5;
  /// Where `known_share` of the new surface can be compared with the old shape, so much of that
  /// must lie on it: another thing took the place beside it otherwise.
  double pushed_fit_share = 0.95;
  /// Nor may another thing that is alike, and missed too, have stood within so many times the
  /// distance: then it may be either.
  double rival_distance = 1.5;

  /// Share of the new surface that must lie where the old shape knows anything, once it is laid
  /// over it, ...
  double known_share = 0.5;
  /// ... and of that, on its surface, for the old shape to be kept.
  double fit_share = 0.85;
  /// Weight of what is kept of the old shape, at most: the next looks correct it.
  double kept_weight = 1.0;
};

/// Looks for moves that end in the objects in view which stand there for less than `recent_s`, and
/// makes one object of both ends: it keeps the id and the history of the old one, stands in the new
/// place, and knows both what was seen of it there and, if the shapes match, what was known of it
/// before. `MOVED` tells it, with a confidence. The object of the new place is forgotten.
///
/// Pushed things are found by nearness; at any distance, a thing that was given up is found by its
/// shape, if no other object of the map looks like it: twins are never guessed.
void FindRelocations(const std::vector<ObjectInView>& in_view,
                     double recent_s,
                     const RelocationParameters& parameters,
                     WorkingMap* map);

}  // namespace steadymap
