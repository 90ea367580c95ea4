#include "core/association/class_votes.h"

#include <algorithm>

namespace steadymap {

void AddVotes(const std::map<ClassId, std::size_t>& samples_by_class, ObjectState* object) {
  std::size_t total = 0;
  for (const auto& [class_id, samples] : samples_by_class) total += samples;
  for (const auto& [class_id, samples] : samples_by_class) {
    auto vote = std::lower_bound(
        object->votes.begin(),
        object->votes.end(),
        class_id,
        [](const ClassVote& known, ClassId sought) { return known.class_id < sought; });
    if (vote == object->votes.end() || vote->class_id != class_id) {
      vote = object->votes.insert(vote, {class_id, 0.0});
    }
    vote->weight += static_cast<double>(samples) / static_cast<double>(total);
  }
  const auto winner = std::max_element(
      object->votes.begin(), object->votes.end(), [](const ClassVote& a, const ClassVote& b) {
        return a.weight < b.weight;
      });
  if (winner != object->votes.end()) object->class_id = winner->class_id;
}

}  // namespace steadymap
