#include "core/objects/session_moves.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/geometry/assignment.h"
#include "core/geometry/cuboid.h"
#include "core/objects/surface_overlap.h"
#include "core/objects/surface_relations.h"
#include "core/types/parallel.h"

namespace steadymap {
namespace {

// How much more likely a push is than a move from elsewhere, in margins between rivals.
constexpr double kPushMargins = 2.0;

class MoveSearch {
 public:
  MoveSearch(const SessionIdentityParameters& parameters,
             const VoxelScale& scale,
             SessionObjects* objects)
      : parameters_(parameters), scale_(scale), objects_(objects) {}

  std::vector<SessionMove> Run() {
    std::vector<SessionMove> candidates = ListMoves();
    DropPushed(candidates);
    std::erase_if(candidates, [&](const SessionMove& candidate) {
      return DoubtedFitOf(*candidate.seen, *candidate.known) >= candidate.match.confidence();
    });
    return FindClearMoves(candidates);
  }

 private:
  bool IsPushed(const KnownObject& known, const ShapeMatch& match) const;
  static bool MayHaveMoved(const SeenObject& seen, const KnownObject& known);
  bool AreOfOneSize(const TrackedObject& seen, const TrackedObject& known) const;
  bool IsDoubtedMatch(const SeenObject& seen, const KnownObject& known) const;
  std::vector<SessionMove> ListMoves() const;
  void DropPushed(const std::vector<SessionMove>& candidates);
  double DoubtedFitOf(const SeenObject& seen, const KnownObject& known) const;
  double LikelihoodOf(const SessionMove& candidate) const;
  std::vector<SessionMove> FindClearMoves(const std::vector<SessionMove>& candidates) const;

  const SessionIdentityParameters& parameters_;
  const VoxelScale& scale_;
  SessionObjects* objects_;
};

/// True if an object of the session that may be a known one in place rather is that one at a new
/// place: all surface that was known is there.
bool MoveSearch::IsPushed(const KnownObject& known, const ShapeMatch& match) const {
  const Eigen::Isometry3d T_object_world =
      known.object->state().T_world_object.ToIsometry().inverse();
  const Eigen::Vector3d center_world = known.object->cuboid().center_world;
  const Eigen::Vector3d moved_world = match.T_world_object * (T_object_world * center_world);
  const SurfaceOverlap self =
      CompareSurfaces(*known.object, *known.object, T_object_world * match.T_world_object, scale_);
  if ((moved_world - center_world).norm() <= parameters_.max_displacement_m &&
      self.known_share * self.fit_share >= 1.0 - parameters_.max_dissimilarity) {
    return false;
  }
  const SurfaceOverlap& overlap = match.reverse_overlap;
  return overlap.known_share * overlap.fit_share >= 1.0 - parameters_.max_dissimilarity;
}

/// True if a known object is not where it was, or if it was pushed to where an object of the
/// session hides its place.
bool MoveSearch::MayHaveMoved(const SeenObject& seen, const KnownObject& known) {
  if (known.object->is_archived()) return !IsOlderThanRemoval(seen, known);
  if (known.standing == Standing::kGone) return true;
  return known.standing == Standing::kUnverified &&
         DistanceBetween(known.object->cuboid(), seen.object->cuboid()) <= 0.0;
}

/// True if the surfaces of two objects are large enough to be of one.
bool MoveSearch::AreOfOneSize(const TrackedObject& seen, const TrackedObject& known) const {
  return seen.SurfaceAreaM2() >= parameters_.min_moved_area_share * known.SurfaceAreaM2() &&
         known.SurfaceAreaM2() >= parameters_.min_shape_known_share * seen.SurfaceAreaM2();
}

bool MoveSearch::IsDoubtedMatch(const SeenObject& seen, const KnownObject& known) const {
  return std::any_of(
      objects_->doubted.begin(), objects_->doubted.end(), [&](const PlaceMatch& match) {
        return match.seen == &seen && match.known == &known;
      });
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
      const double distance_m = DistanceBetween(known.object->cuboid(), seen.object->cuboid());
      candidates.push_back({&seen, &known, {}, distance_m});
    }
  }
  // The cuboids, which are computed at the first use, are known from here on.
  ParallelFor(candidates.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      SessionMove& candidate = candidates[i];
      candidate.match = MatchShapes(*candidate.known->object, *candidate.seen->object, scale_);
    }
  });
  std::erase_if(candidates, [&](const SessionMove& candidate) {
    return candidate.match.overlap.known_share < parameters_.min_shape_known_share ||
           candidate.match.close_share() < parameters_.min_shape_close_share ||
           (IsDoubtedMatch(*candidate.seen, *candidate.known) &&
            !IsPushed(*candidate.known, candidate.match));
  });
  std::stable_sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
    return a.match.confidence() > b.match.confidence();
  });
  return candidates;
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

/// Returns how well an object of the session, or a known object, agrees with standing in place
/// despite what is gone, in [0, 1].
double MoveSearch::DoubtedFitOf(const SeenObject& seen, const KnownObject& known) const {
  double best = 0.0;
  for (const PlaceMatch& match : objects_->doubted) {
    if (match.seen->is_decided || match.known->is_taken) continue;
    if (match.seen != &seen && match.known != &known) continue;
    best =
        std::max(best, match.fit * (1.0 - DoubtOf(*match.known->object, *objects_, parameters_)));
  }
  return best;
}

/// Returns how likely a move is, on the scale of `rival_margin`. What is not known of a shape does
/// not tell it from another one. Of two equal shapes, the one whose place overlaps was pushed.
double MoveSearch::LikelihoodOf(const SessionMove& candidate) const {
  const bool is_pushed = candidate.distance_m <= 0.0 && IsPushed(*candidate.known, candidate.match);
  return candidate.match.close_share() +
         (is_pushed ? kPushMargins * parameters_.rival_margin : 0.0);
}

/// Returns the moves without which the best explanation of all changes would be clearly worse.
std::vector<SessionMove> MoveSearch::FindClearMoves(
    const std::vector<SessionMove>& candidates) const {
  std::vector<AssignmentPair> pairs;
  pairs.reserve(candidates.size());
  for (const SessionMove& candidate : candidates) {
    pairs.push_back({candidate.seen->index, candidate.known->index, -LikelihoodOf(candidate)});
  }
  const std::vector<std::optional<std::size_t>> columns = AssignClearColumns(
      objects_->seen.size(), objects_->known.size(), pairs, 0.0, parameters_.rival_margin);
  std::vector<SessionMove> clear;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (columns[pairs[i].row] == pairs[i].column) clear.push_back(candidates[i]);
  }
  return clear;
}

}  // namespace

std::vector<SessionMove> FindSessionMoves(const SessionIdentityParameters& parameters,
                                          const VoxelScale& scale,
                                          SessionObjects* objects) {
  return MoveSearch(parameters, scale, objects).Run();
}

}  // namespace steadymap
