#include "core/objects/place_matches.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <optional>

#include "core/objects/session_alignment.h"
#include "core/objects/session_parts.h"
#include "core/objects/surface_overlap.h"
#include "core/registration/registration.h"

namespace steadymap {
namespace {

// Standard deviation of a normal distribution, in medians of its magnitude.
constexpr double kSigmasOfMedian = 1.4826;

/// Matches two objects in place by the nearest voxels: registration interpolates between eight
/// observed ones, which things that are thinner than two voxels hardly have.
std::optional<PlaceMatch> MatchThin(const SessionIdentityParameters& parameters,
                                    const VoxelScale& scale,
                                    SeenObject* seen,
                                    KnownObject* known) {
  const Eigen::Isometry3d T_known_world =
      known->object->state().T_world_object.ToIsometry().inverse();
  const Eigen::Isometry3d T_known_seen =
      T_known_world * seen->object->state().T_world_object.ToIsometry();
  const SurfaceOverlap overlap =
      CompareSurfaces(*seen->object, *known->object, T_known_seen, parameters.parts.surface, scale);
  if (overlap.known_share < parameters.parts.shares.substantial ||
      overlap.fit_share < parameters.parts.shares.nearly_all()) {
    return std::nullopt;
  }
  return PlaceMatch{seen, known, 0.0, overlap.known_fit_share(), true};
}

/// Matches an object of the session with a known one of its class around it, if they agree.
std::optional<PlaceMatch> MatchPlace(const SessionIdentityParameters& parameters,
                                     const VoxelScale& scale,
                                     SeenObject* seen,
                                     KnownObject* known) {
  const std::optional<Registration> registration =
      RegisterToKnown(*seen->object, *known->object, scale);
  if (!registration) return std::nullopt;
  if (registration->known_share < parameters.parts.shares.substantial) {
    return MatchThin(parameters, scale, seen, known);
  }
  if (registration->dissimilarity > parameters.parts.shares.negligible) return std::nullopt;
  const double displacement_m = DisplacementOf(*registration, *seen->object);
  // Less of its shape need be known of what is just where it stood.
  const bool is_displaced = displacement_m > parameters.max_displacement_m;
  if (known->object->is_archived() && is_displaced &&
      registration->known_share < parameters.parts.shares.majority) {
    return std::nullopt;
  }
  const double fit = registration->known_share * (1.0 - registration->dissimilarity);
  const bool fits_at_rest =
      !IsDisplaced(*registration, *seen->object, *known->object, parameters, scale);
  return PlaceMatch{seen, known, displacement_m, fit, fits_at_rest};
}

}  // namespace

std::vector<PlaceMatch> FindPlaceMatches(const SessionIdentityParameters& parameters,
                                         const VoxelScale& scale,
                                         SessionObjects* objects) {
  std::vector<PlaceMatch> matches;
  for (SeenObject& seen : objects->seen) {
    if (seen.is_decided) continue;
    for (KnownObject& known : objects->known) {
      const std::optional<PlaceMatch> match = MatchPlace(parameters, scale, &seen, &known);
      if (match) matches.push_back(*match);
    }
  }
  // What stands there is more likely than what left.
  std::stable_sort(matches.begin(), matches.end(), [](const PlaceMatch& a, const PlaceMatch& b) {
    if (a.known->object->is_archived() != b.known->object->is_archived()) {
      return b.known->object->is_archived();
    }
    return a.fit > b.fit;
  });
  return matches;
}

double InPlaceLimit(const std::vector<PlaceMatch>& matches,
                    const SeenObject& seen,
                    const SessionIdentityParameters& parameters) {
  std::map<const SeenObject*, double> least_m;
  for (const PlaceMatch& match : matches) {
    if (match.seen == &seen || match.known->object->is_archived() ||
        IsFragmentOf(*match.seen->object, *match.known->object, parameters.parts)) {
      continue;
    }
    const auto [entry, is_new] = least_m.emplace(match.seen, match.displacement_m);
    if (!is_new) entry->second = std::min(entry->second, match.displacement_m);
  }
  if (least_m.empty()) return parameters.max_displacement_m;
  std::vector<double> others_m;
  others_m.reserve(least_m.size());
  for (const auto& [other, displacement_m] : least_m) others_m.push_back(displacement_m);
  const auto middle = others_m.begin() + static_cast<std::ptrdiff_t>((others_m.size() - 1) / 2);
  std::nth_element(others_m.begin(), middle, others_m.end());
  return std::clamp(parameters.max_pose_sigmas * kSigmasOfMedian * *middle,
                    parameters.max_displacement_m,
                    parameters.max_session_offset_m);
}

}  // namespace steadymap
