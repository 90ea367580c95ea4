#include "core/objects/session_moves.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <optional>
#include <vector>

#include "core/geometry/assignment.h"
#include "core/geometry/cuboid.h"
#include "core/objects/session_alignment.h"
#include "core/objects/support.h"
#include "core/objects/surface_overlap.h"
#include "core/objects/surface_relations.h"
#include "core/types/parallel.h"

namespace steadymap {
namespace {

class MoveSearch {
 public:
  MoveSearch(const SessionIdentityParameters& parameters,
             const FreeSpaceSince& free_space,
             const WorkingMap& map,
             SessionObjects* objects)
      : parameters_(parameters),
        free_space_(free_space),
        map_(map),
        scale_(map.scale()),
        objects_(objects) {}

  std::vector<SessionMove> Run() {
    std::vector<SessionMove> candidates = ListMoves();
    std::erase_if(candidates,
                  [&](const SessionMove& candidate) { return IsOfStanding(candidate); });
    DropPushed(candidates);
    return FindClearMoves(DropRefuted(candidates));
  }

 private:
  bool IsPushed(const SeenObject& seen, const KnownObject& known, const ShapeMatch& match) const;
  bool MayHaveMoved(const SeenObject& seen, const KnownObject& known) const;
  bool MayStand(const SeenObject& seen, const KnownObject& known) const;
  bool AreOfOneSize(const TrackedObject& seen, const TrackedObject& known) const;
  double MaxStepM(const SessionMove& candidate) const;
  double MinCloseShare(const SessionMove& candidate) const;
  bool IsDoubtedMatch(const SeenObject& seen, const KnownObject& known) const;
  std::vector<SessionMove> ListMoves() const;
  bool IsOfStanding(const SessionMove& candidate) const;
  bool IsRefuted(const SessionMove& candidate, const std::vector<SessionMove>& candidates) const;
  std::vector<SessionMove> DropRefuted(const std::vector<SessionMove>& candidates) const;
  void DropPushed(const std::vector<SessionMove>& candidates);
  double LikelihoodOf(const SessionMove& candidate) const;
  std::vector<SessionMove> FindClearMoves(const std::vector<SessionMove>& candidates) const;

  const SessionIdentityParameters& parameters_;
  const FreeSpaceSince& free_space_;
  const WorkingMap& map_;
  const VoxelScale& scale_;
  SessionObjects* objects_;
};

/// True if a motion takes a cuboid to where it was, up to a distance: also by half a turn, or by a
/// quarter of one if it is square.
bool KeepsCuboid(const Eigen::Isometry3d& motion, const Cuboid& cuboid, double max_distance_m) {
  const std::array<Eigen::Vector2d, 4> corners = cuboid.BaseCorners();
  return std::all_of(corners.begin(), corners.end(), [&](const Eigen::Vector2d& corner) {
    const Eigen::Vector3d corner_world(corner.x(), corner.y(), cuboid.lowest_m());
    const Eigen::Vector2d moved = (motion * corner_world).head<2>();
    return std::any_of(corners.begin(), corners.end(), [&](const Eigen::Vector2d& other) {
      return (moved - other).norm() <= max_distance_m;
    });
  });
}

/// Returns the cuboid of what two objects are together.
Cuboid JointCuboid(const TrackedObject& a, const TrackedObject& b) {
  std::vector<Eigen::Vector3d> points_world = a.SurfaceInWorld();
  const std::vector<Eigen::Vector3d> others_world = b.SurfaceInWorld();
  points_world.insert(points_world.end(), others_world.begin(), others_world.end());
  return FitCuboid(points_world);
}

/// True if an object of the session that may be a known one in place rather is that one, displaced
/// or turned: clearly more of the surfaces then agrees. What only one of them shows agrees with
/// even odds; if the cuboid stays in its place, as that of a table seen from its other side, it
/// agrees.
bool MoveSearch::IsPushed(const SeenObject& seen,
                          const KnownObject& known,
                          const ShapeMatch& match) const {
  const UprightPose& pose = known.object->state().T_world_object;
  const Eigen::Isometry3d motion = match.T_world_object * pose.ToIsometry().inverse();
  if (DisplacementOf(motion, *known.object) <=
      std::max(seen.pose_error_m, 0.5 * scale_.voxel_size_m)) {
    return false;
  }
  const double contact_m = parameters_.parts.surface.contact_voxels * scale_.voxel_size_m;
  const bool is_in_place = KeepsCuboid(motion, JointCuboid(*seen.object, *known.object), contact_m);
  const double odds = is_in_place ? 1.0 : 0.5;
  const MutualOverlap in_place =
      CompareInPlace(*seen.object, *known.object, parameters_.parts.surface, scale_, &free_space_);
  const double known_share = std::min(in_place.reverse_overlap.expected_share(odds),
                                      1.0 - DoubtOf(*known.object, *objects_, parameters_));
  const double in_place_share = 0.5 * (in_place.overlap.expected_share(odds) + known_share);
  return match.expected_share(odds) >= in_place_share + parameters_.parts.shares.negligible;
}

/// True if a known object is not where it was, or if it may have been pushed or turned to where an
/// object of the session is.
bool MoveSearch::MayHaveMoved(const SeenObject& seen, const KnownObject& known) const {
  if (known.object->is_archived()) return !IsOlderThanRemoval(seen, known);
  return known.standing == Standing::kGone || known.standing == Standing::kUnverified ||
         IsDoubtedMatch(seen, known) ||
         DistanceBetween(known.object->cuboid(), seen.object->cuboid()) <= 0.0;
}

/// True if an object of the session may be a known one that nobody moved.
bool MoveSearch::MayStand(const SeenObject& seen, const KnownObject& known) const {
  return IsDoubtedMatch(seen, known) ||
         (!known.object->is_archived() && known.standing != Standing::kGone &&
          known.standing != Standing::kUnverified);
}

/// True if the surfaces of two objects are large enough to be of one. Of an object at a new place,
/// a look may show one side only.
bool MoveSearch::AreOfOneSize(const TrackedObject& seen, const TrackedObject& known) const {
  return seen.SurfaceAreaM2() >= parameters_.parts.shares.negligible * known.SurfaceAreaM2() &&
         known.SurfaceAreaM2() >= parameters_.parts.shares.majority * seen.SurfaceAreaM2();
}

bool MoveSearch::IsDoubtedMatch(const SeenObject& seen, const KnownObject& known) const {
  return std::any_of(
      objects_->doubted.begin(), objects_->doubted.end(), [&](const PlaceMatch& match) {
        return match.seen == &seen && match.known == &known;
      });
}

/// Returns the share of two surfaces that must agree if they are of one object: most, less the
/// standard deviation of a share that so few points tell.
double MoveSearch::MinCloseShare(const SessionMove& candidate) const {
  const double most = parameters_.parts.shares.most();
  const auto points =
      static_cast<double>(std::min(candidate.seen->object->surface().point_count(),
                                   candidate.known->object->surface().point_count()));
  return most - std::sqrt(most * (1.0 - most) / points);
}

/// Returns by how much the lowest points of a known object may differ in height from those of an
/// object of the session that it is: if both stand on the background, by no more than the errors.
double MoveSearch::MaxStepM(const SessionMove& candidate) const {
  if (!StandsOnBackground(*candidate.known->object, parameters_.parts, map_) ||
      !StandsOnBackground(*candidate.seen->object, parameters_.parts, map_)) {
    return std::numeric_limits<double>::infinity();
  }
  const SurfaceMatchParameters& surface = parameters_.parts.surface;
  return surface.contact_voxels * scale_.voxel_size_m +
         surface.max_sigmas * SurfaceSigmaM(surface, scale_);
}

/// Returns the known objects that each undecided object of the session may be, at a new place.
std::vector<SessionMove> MoveSearch::ListMoves() const {
  std::vector<SessionMove> candidates;
  for (SeenObject& seen : objects_->seen) {
    if (seen.is_decided) continue;
    for (KnownObject& known : objects_->known) {
      if (known.is_taken || !IsOfOneClass(*seen.object, *known.object) ||
          !MayHaveMoved(seen, known) || !AreOfOneSize(*seen.object, *known.object)) {
        continue;
      }
      // Cuboids are computed at their first use, which must not be in a parallel loop.
      static_cast<void>(known.object->cuboid());
      static_cast<void>(seen.object->cuboid());
      candidates.push_back({&seen, &known, {}});
    }
  }
  ParallelFor(candidates.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      SessionMove& candidate = candidates[i];
      candidate.match = MatchShapes(*candidate.known->object,
                                    *candidate.seen->object,
                                    free_space_,
                                    parameters_.parts.surface,
                                    scale_,
                                    MaxStepM(candidate));
    }
  });
  std::erase_if(candidates, [&](const SessionMove& candidate) {
    return candidate.match.overlap.known_share < parameters_.parts.shares.majority ||
           candidate.match.close_share() < MinCloseShare(candidate) ||
           (MayStand(*candidate.seen, *candidate.known) &&
            !IsPushed(*candidate.seen, *candidate.known, candidate.match));
  });
  std::stable_sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
    return a.match.confidence() > b.match.confidence();
  });
  return candidates;
}

/// True if one of both objects stands in place beside the other one's.
bool MoveSearch::IsOfStanding(const SessionMove& candidate) const {
  return std::any_of(
      objects_->doubted.begin(), objects_->doubted.end(), [&](const PlaceMatch& match) {
        return (match.seen == candidate.seen) != (match.known == candidate.known) &&
               match.close_share >= parameters_.parts.shares.most() &&
               DoubtOf(*match.known->object, *objects_, parameters_) <
                   parameters_.parts.shares.majority;
      });
}

/// True if both objects clearly have the shape of another one: the surface in which they differ is
/// no error, even if one was close to where the other one is.
bool MoveSearch::IsRefuted(const SessionMove& candidate,
                           const std::vector<SessionMove>& candidates) const {
  const double clearly_better = candidate.match.close_share() + parameters_.parts.shares.negligible;
  const auto any_better = [&](const auto& shares_object) {
    return std::any_of(candidates.begin(), candidates.end(), [&](const SessionMove& other) {
      return shares_object(other) && other.match.close_share() > clearly_better;
    });
  };
  return any_better([&](const SessionMove& other) { return other.seen == candidate.seen; }) &&
         any_better([&](const SessionMove& other) { return other.known == candidate.known; });
}

std::vector<SessionMove> MoveSearch::DropRefuted(const std::vector<SessionMove>& candidates) const {
  std::vector<SessionMove> likely;
  std::copy_if(candidates.begin(),
               candidates.end(),
               std::back_inserter(likely),
               [&](const SessionMove& candidate) { return !IsRefuted(candidate, candidates); });
  return likely;
}

/// Gives up matches in place that a push explains better, also if several objects may be pushed.
void MoveSearch::DropPushed(const std::vector<SessionMove>& candidates) {
  std::erase_if(objects_->doubted, [&](const PlaceMatch& doubted) {
    return std::any_of(candidates.begin(), candidates.end(), [&](const SessionMove& candidate) {
      return doubted.seen == candidate.seen && doubted.known == candidate.known &&
             doubted.fit * (1.0 - DoubtOf(*doubted.known->object, *objects_, parameters_)) <
                 candidate.match.confidence();
    });
  });
}

/// Returns how likely a move is, as an agreement of surfaces. What is not known of a shape does not
/// tell it from another one. Of two equal shapes, the one whose place overlaps was pushed: clearly,
/// even if the other one agrees better within what errors explain.
double MoveSearch::LikelihoodOf(const SessionMove& candidate) const {
  const bool is_pushed =
      DistanceBetween(candidate.known->object->cuboid(), candidate.seen->object->cuboid()) <= 0.0 &&
      IsPushed(*candidate.seen, *candidate.known, candidate.match);
  return candidate.match.close_share() +
         (is_pushed ? 2.0 * parameters_.parts.shares.negligible : 0.0);
}

/// Returns the moves without which the best explanation of all changes would be clearly worse.
std::vector<SessionMove> MoveSearch::FindClearMoves(
    const std::vector<SessionMove>& candidates) const {
  std::vector<AssignmentPair> pairs;
  pairs.reserve(candidates.size());
  for (const SessionMove& candidate : candidates) {
    pairs.push_back({candidate.seen->index, candidate.known->index, -LikelihoodOf(candidate)});
  }
  const std::vector<std::optional<std::size_t>> columns =
      AssignClearColumns(objects_->seen.size(),
                         objects_->known.size(),
                         pairs,
                         0.0,
                         parameters_.parts.shares.negligible);
  std::vector<SessionMove> clear;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (columns[pairs[i].row] == pairs[i].column) clear.push_back(candidates[i]);
  }
  return clear;
}

}  // namespace

std::vector<SessionMove> FindSessionMoves(const SessionIdentityParameters& parameters,
                                          const FreeSpaceSince& free_space,
                                          const WorkingMap& map,
                                          SessionObjects* objects) {
  return MoveSearch(parameters, free_space, map, objects).Run();
}

}  // namespace steadymap
