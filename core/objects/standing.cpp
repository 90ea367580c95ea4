#include "core/objects/standing.h"

#include <algorithm>
#include <optional>

#include "core/change/surface_looks.h"
#include "core/objects/session_alignment.h"
#include "core/objects/surface_overlap.h"
#include "core/objects/surface_relations.h"

namespace steadymap {
namespace {

/// Returns how many looked-at cells decide on an object: of small voxels more, since noise and pose
/// errors let looks pass the outline of an object by centimetres.
std::size_t MinLookedAtCells(const LookCount& looks,
                             const SessionIdentityParameters& parameters,
                             const VoxelScale& scale) {
  const double cell_m = kEvidenceSide * scale.voxel_size_m;
  const double cells =
      std::min(parameters.min_looked_at_area_m2 / (cell_m * cell_m),
               parameters.parts.shares.substantial * static_cast<double>(looks.cells));
  return std::max(looks.DecidingCells(parameters.parts.min_points),
                  static_cast<std::size_t>(cells));
}

/// True if two surfaces, of each of which the volume of the other one tells a substantial share,
/// hardly agree anywhere.
bool HaveOtherSurfaces(const TrackedObject& a,
                       const TrackedObject& b,
                       const SessionPartParameters& parameters,
                       const VoxelScale& scale) {
  const MutualOverlap overlap = CompareInPlace(a, b, parameters.surface, scale);
  return overlap.overlap.known_share >= parameters.shares.substantial &&
         overlap.reverse_overlap.known_share >= parameters.shares.substantial &&
         overlap.close_share() < parameters.shares.negligible;
}

/// True if another object is where the known one was, so that it cannot be there.
bool Replaces(const TrackedObject& other,
              const TrackedObject& known,
              bool is_doubted,
              const SessionIdentityParameters& parameters,
              const VoxelScale& scale) {
  const bool is_in_its_space = ShareSpace(other, known, parameters.parts.shares);
  if (is_doubted) return is_in_its_space;
  if (is_in_its_space && HaveOtherSurfaces(other, known, parameters.parts, scale)) return true;
  const std::optional<Registration> registration = RegisterToKnown(other, known, scale);
  return registration && registration->dissimilarity <= parameters.parts.shares.negligible &&
         registration->known_share >= parameters.parts.shares.most() &&
         IsDisplaced(*registration, other, known, parameters, scale);
}

/// True if another object is in front of what was seen of the known one, so that it was not there
/// then.
bool Hides(const TrackedObject& other,
           const TrackedObject& known,
           const SessionIdentityParameters& parameters,
           const VoxelScale& scale) {
  return DistanceBetween(other.cuboid(), known.cuboid()) <= 0.0 &&
         HiddenShare(known, other, scale) >= parameters.parts.shares.substantial;
}

}  // namespace

bool ShareSpace(const TrackedObject& a, const TrackedObject& b, const SurfaceShares& shares) {
  const double smaller_m3 = std::min(a.cuboid().volume_m3(), b.cuboid().volume_m3());
  return OverlapM3(a.cuboid(), b.cuboid()) > shares.substantial * smaller_m3;
}

double GoneShareOf(const TrackedObject& object) {
  const LookCount looks = CountLooks(object);
  if (looks.looked_at() == 0) return 0.0;
  return static_cast<double>(looks.gone) / static_cast<double>(looks.looked_at());
}

Standing JudgeStanding(const TrackedObject& known,
                       const std::vector<const TrackedObject*>& others,
                       const SessionIdentityParameters& parameters,
                       const VoxelScale& scale) {
  const LookCount looks = CountLooks(known);
  if (looks.looked_at() < MinLookedAtCells(looks, parameters, scale)) return Standing::kUnknown;
  const bool is_doubted = GoneShareOf(known) >= parameters.parts.shares.negligible;
  const double contact_m = parameters.parts.surface.contact_voxels * scale.voxel_size_m;
  const std::size_t verified =
      looks.looked_at() - CountExplainedCells(known, others, contact_m, scale);
  if (is_doubted && static_cast<double>(looks.gone) >=
                        parameters.parts.shares.majority * static_cast<double>(verified)) {
    return Standing::kGone;
  }
  const auto any_other = [&](const auto& is_so) {
    return std::any_of(others.begin(), others.end(), is_so);
  };
  if (any_other([&](const TrackedObject* other) {
        return Replaces(*other, known, is_doubted, parameters, scale);
      })) {
    return Standing::kGone;
  }
  const bool is_verified = verified >= looks.DecidingCells(parameters.parts.min_points);
  return !is_verified && any_other([&](const TrackedObject* other) {
    return Hides(*other, known, parameters, scale);
  })
             ? Standing::kUnverified
             : Standing::kStands;
}

}  // namespace steadymap
