#include <cstdint>
#include <utility>

#include "client/evaluation/map_score.h"
#include "client/evaluation/point_index.h"

namespace steadymap {
namespace {

// Sequences before the last, a bit each.
std::uint32_t EarlierBits(const RouteSurvey& survey) { return (1U << survey.last_sequence()) - 1U; }

void SortStandingPlace(const SurveyedPlace& place,
                       const RouteSurvey& survey,
                       Reference* reference) {
  const std::uint32_t last_bit = 1U << survey.last_sequence();
  for (std::size_t i = 0; i < place.points.size(); ++i) {
    const bool is_seen = (place.seen_in[i] & last_bit) != 0;
    (is_seen ? reference->seen : reference->unseen).push_back(place.points[i]);
    if (!is_seen && (place.seen_in[i] & EarlierBits(survey)) != 0) {
      reference->remembered.push_back(place.points[i]);
    }
  }
}

void SortVanishedPlace(const SurveyedPlace& place,
                       const RouteSurvey& survey,
                       const PointIndex& truth,
                       Reference* reference) {
  const std::uint32_t last_bit = 1U << survey.last_sequence();
  for (std::size_t i = 0; i < place.points.size(); ++i) {
    const bool was_seen = (place.seen_in[i] & EarlierBits(survey)) != 0;
    const bool is_refuted = (place.looked_through_in[i] & last_bit) != 0;
    if (!was_seen || !is_refuted || truth.HasNear(place.points[i].position_world)) continue;
    reference->vanished.push_back(place.points[i]);
  }
}

}  // namespace

Reference MakeReference(RouteSurvey* survey, bool with_ground) {
  const double voxel_size_m = survey->last_observed.voxel_size_m();
  Reference reference{.observed = std::move(survey->last_observed)};
  // What lies within the tolerance of the truth is no ghost: the score could not tell it from
  // truth.
  PointIndex truth(0.5 * voxel_size_m);
  for (const SurveyedPlace& place : survey->places) {
    if (!place.StandsIn(survey->last_sequence())) continue;
    truth.Add(place.points);
    if (place.semantic_class == SceneClass::kGround && !with_ground) {
      reference.ignored.insert(reference.ignored.end(), place.points.begin(), place.points.end());
    } else {
      SortStandingPlace(place, *survey, &reference);
    }
  }
  for (const SurveyedPlace& place : survey->places) {
    if (place.StandsIn(survey->last_sequence())) continue;
    SortVanishedPlace(place, *survey, truth, &reference);
  }
  return reference;
}

}  // namespace steadymap
