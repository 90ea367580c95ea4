#include "core/association/class_votes.h"

#include <algorithm>

namespace steadymap {

void AddVotes(const std::map<ClassId, std::size_t>& samples_by_class, ObjectState* object) {
  std::size_t total = 0;
  for (const auto& [class_id, samples] : samples_by_class) total += samples;
  std::vector<ClassVote> votes;
  votes.reserve(samples_by_class.size());
  for (const auto& [class_id, samples] : samples_by_class) {
    votes.push_back({class_id, static_cast<double>(samples) / static_cast<double>(total)});
  }
  JoinVotes(votes, object);
}

void JoinVotes(const std::vector<ClassVote>& votes, ObjectState* object) {
  for (const ClassVote& added : votes) {
    auto vote = std::lower_bound(
        object->votes.begin(),
        object->votes.end(),
        added.class_id,
        [](const ClassVote& known, ClassId sought) { return known.class_id < sought; });
    if (vote == object->votes.end() || vote->class_id != added.class_id) {
      vote = object->votes.insert(vote, {added.class_id, 0.0});
    }
    vote->weight += added.weight;
  }
  const auto winner = std::max_element(
      object->votes.begin(), object->votes.end(), [](const ClassVote& a, const ClassVote& b) {
        return a.weight < b.weight;
      });
  if (winner != object->votes.end()) object->class_id = winner->class_id;
}

}  // namespace steadymap
