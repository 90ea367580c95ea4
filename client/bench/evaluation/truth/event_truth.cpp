#include "client/bench/evaluation/truth/event_truth.h"

#include <algorithm>
#include <cstdint>

namespace steadymap {
namespace {

// Less surface is hardly noticeable in a map: half the side of a small parcel.
constexpr double kMinSurfaceM2 = 0.1;

using PlaceList = std::vector<const SurveyedPlace*>;

ClassId ClassOf(const SurveyedPlace& place) {
  return ClassId(static_cast<std::uint16_t>(place.semantic_class));
}

double AreaSeenM2(const SurveyedPlace& place, std::uint32_t sequences, const RouteSurvey& survey) {
  const auto count = std::count_if(place.seen_in.begin(),
                                   place.seen_in.end(),
                                   [=](std::uint32_t seen) { return (seen & sequences) != 0; });
  return static_cast<double>(count) * survey.point_area_m2;
}

// Returns the area of surface that earlier sequences observed and that `sequence` measured depth
// behind.
double AreaRefutedM2(const SurveyedPlace& place, std::size_t sequence, const RouteSurvey& survey) {
  const std::uint32_t bit = 1U << sequence;
  std::size_t count = 0;
  for (std::size_t i = 0; i < place.points.size(); ++i) {
    const bool was_seen = (place.seen_in[i] & (bit - 1U)) != 0;
    if (was_seen && (place.looked_through_in[i] & bit) != 0) ++count;
  }
  return static_cast<double>(count) * survey.point_area_m2;
}

const SurveyedPlace* FindPlace(const RouteSurvey& survey,
                               std::uint16_t object,
                               std::size_t sequence) {
  for (const SurveyedPlace& place : survey.places) {
    if (place.object == object && place.StandsIn(sequence)) return &place;
  }
  return nullptr;
}

void AddFrames(const SurveyedPlace& place,
               std::size_t sequence,
               const RouteSurvey& survey,
               std::vector<std::size_t>* frames) {
  for (const std::size_t frame : place.frames_in_view) {
    if (frame < survey.first_frames[sequence] || frame >= survey.first_frames[sequence + 1]) {
      continue;
    }
    frames->push_back(frame);
  }
  std::sort(frames->begin(), frames->end());
  frames->erase(std::unique(frames->begin(), frames->end()), frames->end());
}

/// Collects the changes of one sequence, grouped by object group.
class ChangeCollector {
 public:
  ChangeCollector(const RouteSurvey& survey, std::size_t sequence, EventTruth* truth)
      : survey_(survey), sequence_(sequence), first_(truth->changes.size()), truth_(truth) {}

  // Either place may be null, but not both.
  void Add(const SurveyedPlace* left, const SurveyedPlace* taken) {
    const SurveyedPlace* const place = left != nullptr ? left : taken;
    if (place == nullptr) return;
    TrueChange& change = ChangeFor(*place, left != nullptr, taken != nullptr);
    if (left != nullptr) {
      change.departure.boxes_world.push_back(left->box_world);
      AddFrames(*left, sequence_, survey_, &change.departure.frames_in_view);
      departed_m2_[IndexOf(change)] += AreaRefutedM2(*left, sequence_, survey_);
      change.departure.is_in_view = departed_m2_[IndexOf(change)] >= kMinSurfaceM2;
    }
    if (taken != nullptr) {
      change.arrival.boxes_world.push_back(taken->box_world);
      AddFrames(*taken, sequence_, survey_, &change.arrival.frames_in_view);
      arrived_m2_[IndexOf(change)] += AreaSeenM2(*taken, 1U << sequence_, survey_);
      change.arrival.is_in_view = arrived_m2_[IndexOf(change)] >= kMinSurfaceM2;
    }
  }

 private:
  std::size_t IndexOf(const TrueChange& change) const {
    return static_cast<std::size_t>(&change - truth_->changes.data()) - first_;
  }

  // Returns the present change of the group, or a new one.
  TrueChange& ChangeFor(const SurveyedPlace& place, bool departs, bool arrives) {
    for (std::size_t i = 0; i < groups_.size(); ++i) {
      TrueChange& change = truth_->changes[first_ + i];
      if (!place.group.empty() && groups_[i] == place.group && change.class_id == ClassOf(place) &&
          departs != change.departure.boxes_world.empty() &&
          arrives != change.arrival.boxes_world.empty()) {
        return change;
      }
    }
    groups_.push_back(place.group);
    departed_m2_.push_back(0.0);
    arrived_m2_.push_back(0.0);
    TrueChange& change = truth_->changes.emplace_back();
    change.name = place.name;
    change.class_id = ClassOf(place);
    change.sequence = sequence_;
    return change;
  }

  const RouteSurvey& survey_;
  std::size_t sequence_;
  std::size_t first_;  // Of this sequence's changes.
  EventTruth* truth_;
  std::vector<std::string> groups_;  // One per change of this sequence, like the areas below.
  std::vector<double> departed_m2_;
  std::vector<double> arrived_m2_;
};

void ListChanges(const Route& route,
                 const RouteSurvey& survey,
                 std::size_t sequence,
                 EventTruth* truth) {
  const SceneChange change =
      CompareScenes(route.sequences[sequence - 1].scene, route.sequences[sequence].scene);
  ChangeCollector collector(survey, sequence, truth);
  for (const std::uint16_t id : change.removed) {
    collector.Add(FindPlace(survey, id, sequence - 1), nullptr);
  }
  for (const std::uint16_t id : change.moved) {
    collector.Add(FindPlace(survey, id, sequence - 1), FindPlace(survey, id, sequence));
  }
  for (const std::uint16_t id : change.created) {
    collector.Add(nullptr, FindPlace(survey, id, sequence));
  }
}

void ListFirstSights(const RouteSurvey& survey, std::size_t sequence, EventTruth* truth) {
  const std::uint32_t bit = 1U << sequence;
  for (const SurveyedPlace& place : survey.places) {
    if (!place.StandsIn(sequence) || AreaSeenM2(place, bit - 1U, survey) >= kMinSurfaceM2) continue;
    truth->first_sights.push_back({ClassOf(place), sequence, place.box_world});
  }
}

}  // namespace

EventTruth ListTrueEvents(const Route& route, const RouteSurvey& survey) {
  EventTruth truth;
  truth.first_frames = survey.first_frames;
  for (std::size_t sequence = 0; sequence < survey.sequence_count; ++sequence) {
    if (sequence > 0) ListChanges(route, survey, sequence, &truth);
    ListFirstSights(survey, sequence, &truth);
  }
  return truth;
}

}  // namespace steadymap
