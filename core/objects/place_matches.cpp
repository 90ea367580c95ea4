#include "core/objects/place_matches.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <optional>

#include "core/objects/session_alignment.h"
#include "core/objects/session_parts.h"
#include "core/registration/registration.h"

namespace steadymap {
namespace {

// Standard deviation of a normal distribution, in medians of its magnitude.
constexpr double kSigmasOfMedian = 1.4826;

}  // namespace

std::vector<PlaceMatch> FindPlaceMatches(const SessionIdentityParameters& parameters,
                                         const VoxelScale& scale,
                                         SessionObjects* objects) {
  std::vector<PlaceMatch> matches;
  for (SeenObject& seen : objects->seen) {
    if (seen.is_decided) continue;
    for (KnownObject& known : objects->known) {
      const std::optional<Registration> registration =
          RegisterToKnown(*seen.object, *known.object, scale);
      if (!registration || registration->dissimilarity > parameters.max_dissimilarity) continue;
      const double displacement_m = DisplacementOf(*registration, *seen.object);
      // Less of its shape need be known of what is just where it stood.
      const bool is_back = known.object->is_archived();
      const double least_known = is_back && displacement_m > parameters.max_displacement_m
                                     ? parameters.min_shape_known_share
                                     : parameters.min_known_share;
      if (registration->known_share < least_known) continue;
      const double fit = registration->known_share * (1.0 - registration->dissimilarity);
      matches.push_back(
          {&seen, &known, displacement_m, fit, FitsAtRest(*registration, parameters)});
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
