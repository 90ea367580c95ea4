#include "client/bench/evaluation/score/route_reference.h"

#include <cstdint>
#include <utility>

#include "client/bench/evaluation/truth/point_index.h"

namespace steadymap {
namespace {

// Sorts the surface of all places into a reference.
class Sorter {
 public:
  Sorter(const RouteSurvey& survey, Reference* reference)
      : last_bit_(1U << survey.last_sequence()),
        earlier_bits_(last_bit_ - 1U),
        truth_(survey.last_observed.voxel_size_m()),
        seen_(survey.last_observed.voxel_size_m()),
        reference_(reference) {}

  void SortStanding(const SurveyedPlace& place) {
    truth_.Add(place.points);
    for (std::size_t i = 0; i < place.points.size(); ++i) {
      const SurfacePoint& point = place.points[i];
      if ((place.seen_in[i] & last_bit_) != 0) {
        reference_->seen.push_back(point);
        seen_.Add(point.position_world);
      } else {
        reference_->unseen.push_back(point);
      }
    }
  }

  void SortGround(const SurveyedPlace& place) {
    truth_.Add(place.points);
    reference_->ground.insert(reference_->ground.end(), place.points.begin(), place.points.end());
  }

  // Requires that all present surface is sorted.
  void SortRemembered(const SurveyedPlace& place) {
    for (std::size_t i = 0; i < place.points.size(); ++i) {
      const SurfacePoint& point = place.points[i];
      if ((place.seen_in[i] & last_bit_) != 0 || (place.seen_in[i] & earlier_bits_) == 0) continue;
      if (!seen_.HasNear(point.position_world)) reference_->remembered.push_back(point);
    }
  }

  // Requires that all present surface is sorted.
  void SortVanished(const SurveyedPlace& place) {
    for (std::size_t i = 0; i < place.points.size(); ++i) {
      const SurfacePoint& point = place.points[i];
      const bool is_refuted = (place.looked_through_in[i] & last_bit_) != 0;
      if (!is_refuted || (place.seen_in[i] & earlier_bits_) == 0) continue;
      if (!truth_.HasNear(point.position_world)) reference_->vanished.push_back(point);
    }
  }

  // Requires that all present surface is sorted.
  void SortSwept(const std::vector<SurfacePoint>& points) {
    for (const SurfacePoint& point : points) {
      if (!truth_.HasNear(point.position_world)) reference_->swept.push_back(point);
    }
  }

 private:
  std::uint32_t last_bit_;
  std::uint32_t earlier_bits_;
  // A map's surface may be off by half a voxel. So that map surface never matches two categories,
  // vanished and swept surface keeps a distance of one voxel from true surface, and remembered
  // surface from seen surface.
  PointIndex truth_;
  PointIndex seen_;
  Reference* reference_;
};

}  // namespace

Reference MakeReference(RouteSurvey* survey, bool with_ground) {
  Reference reference{.observed = {1.0, 1.0}};
  Sorter sorter(*survey, &reference);
  const auto is_scored = [with_ground](const SurveyedPlace& place) {
    return with_ground || place.semantic_class != SceneClass::kGround;
  };
  for (const SurveyedPlace& place : survey->places) {
    if (!place.StandsIn(survey->last_sequence())) continue;
    if (is_scored(place)) {
      sorter.SortStanding(place);
    } else {
      sorter.SortGround(place);
    }
  }
  for (const SurveyedPlace& place : survey->places) {
    if (!is_scored(place)) continue;
    if (place.StandsIn(survey->last_sequence())) {
      sorter.SortRemembered(place);
    } else {
      sorter.SortVanished(place);
    }
  }
  sorter.SortSwept(survey->swept);
  reference.observed = std::move(survey->last_observed);
  return reference;
}

}  // namespace steadymap
