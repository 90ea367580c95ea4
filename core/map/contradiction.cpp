#include "core/map/contradiction.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/map/map_object.h"
#include "core/map/map_snapshot.h"

namespace steadymap {
namespace {

bool IsWithin(Timestamp a, Timestamp b, double window_s) {
  return std::abs((a - b).seconds()) <= window_s;
}

void Add(const SensorName& other,
         const Contradiction& contradiction,
         std::map<SensorName, SensorContradiction>* by_other) {
  SensorContradiction& sum = by_other->try_emplace(other).first->second;
  if (sum.objects == 0 || contradiction.since < sum.since) sum.since = contradiction.since;
  ++sum.objects;
}

}  // namespace

const Contradiction* ReportAbsence(const SensorName& source,
                                   Timestamp time,
                                   double window_s,
                                   ObjectState* object) {
  std::vector<Contradiction>& all = object->contradictions;
  // Longer ago, the object may have changed in between.
  std::erase_if(all,
                [&](const Contradiction& known) { return !IsWithin(known.last, time, window_s); });
  if (object->source == source) all.clear();
  if (object->source.robot.empty() || object->source == source ||
      !IsWithin(object->last_seen, time, window_s)) {
    return nullptr;
  }
  auto found = std::find_if(
      all.begin(), all.end(), [&](const Contradiction& known) { return known.absent == source; });
  if (found == all.end()) {
    if (all.size() >= kMaxContradictions) {
      all.erase(std::min_element(
          all.begin(), all.end(), [](const Contradiction& a, const Contradiction& b) {
            return a.last < b.last;
          }));
    }
    found = all.insert(all.end(), {source, {}, time, time, 0});
  }
  found->present = object->source;
  found->last = time;
  ++found->sessions;
  return &*found;
}

void ReportPresence(const SensorName& source, Timestamp time, ObjectState* object) {
  std::erase_if(object->contradictions, [&](const Contradiction& known) {
    return known.absent == source && known.last <= time;
  });
  if (time < object->last_seen) return;
  object->last_seen = time;
  object->source = source;
}

std::map<SensorName, std::vector<SensorContradiction>> FindContradictions(const MapSnapshot& map) {
  std::map<SensorName, std::map<SensorName, SensorContradiction>> sums;
  for (const auto& [id, object] : map.objects) {
    if (object->status != ObjectStatus::kPresent) continue;
    for (const Contradiction& contradiction : object->contradictions) {
      if (!contradiction.is_confirmed()) continue;
      Add(contradiction.present, contradiction, &sums[contradiction.absent]);
      Add(contradiction.absent, contradiction, &sums[contradiction.present]);
    }
  }
  std::map<SensorName, std::vector<SensorContradiction>> contradictions;
  for (auto& [sensor, others] : sums) {
    for (auto& [other, sum] : others) {
      sum.other = other;
      contradictions[sensor].push_back(std::move(sum));
    }
  }
  return contradictions;
}

}  // namespace steadymap
