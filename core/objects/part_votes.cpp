#include "core/objects/part_votes.h"

#include <algorithm>
#include <cstddef>

namespace steadymap {
namespace {

std::vector<PartVotes>::const_iterator FindVotes(const std::vector<PartVotes>& parts,
                                                 ObjectId other) {
  return std::lower_bound(
      parts.begin(), parts.end(), other, [](const PartVotes& votes, ObjectId id) {
        return votes.other < id;
      });
}

/// True if the bounds of two objects are closer than two voxels, so that they may be connected.
bool AreNear(const TrackedObject& a, const TrackedObject& b, const VoxelScale& scale) {
  return Grow(a.BoundsInWorld(), 2.0 * scale.voxel_size_m).intersects(b.BoundsInWorld());
}

/// Adds to the votes on an object and an older one.
void AddVotes(const PartVotes& added, TrackedObject* object, WorkingMap* map) {
  ObjectEdit edit = map->Edit(object);
  std::vector<PartVotes>& parts = edit.state().parts;
  auto votes = parts.begin() + (FindVotes(parts, added.other) - parts.cbegin());
  if (votes == parts.end() || votes->other != added.other) {
    votes = parts.insert(votes, {added.other});
  }
  votes->connected += added.connected;
  votes->apart += added.apart;
  votes->occluded += added.occluded;
}

}  // namespace

void VoteOnParts(PartVote vote, TrackedObject* a, TrackedObject* b, WorkingMap* map) {
  if (a->id() < b->id()) std::swap(a, b);
  if (vote != PartVote::kConnected && !AreNear(*a, *b, map->scale())) {
    const std::vector<PartVotes>& parts = a->state().parts;
    const auto votes = FindVotes(parts, b->id());
    if (votes == parts.end() || votes->other != b->id()) return;
  }
  AddVotes({.other = b->id(),
            .connected = vote == PartVote::kConnected ? 1U : 0U,
            .apart = vote == PartVote::kApart ? 1U : 0U,
            .occluded = vote == PartVote::kOccluded ? 1U : 0U},
           a,
           map);
}

bool HaveVotes(const TrackedObject& a, const TrackedObject& b) {
  const auto [older, newer] = a.id() < b.id() ? std::pair(&a, &b) : std::pair(&b, &a);
  const std::vector<PartVotes>& parts = newer->state().parts;
  const auto votes = FindVotes(parts, older->id());
  return votes != parts.end() && votes->other == older->id();
}

void InheritVotes(const TrackedObject& whole, TrackedObject* part, WorkingMap* map) {
  {
    ObjectEdit edit = map->Edit(part);
    edit.state().parts = whole.state().parts;
  }
  for (const TrackedObject* object : map->TentativeObjects()) {
    const auto votes = FindVotes(object->state().parts, whole.id());
    if (votes == object->state().parts.end() || votes->other != whole.id()) continue;
    AddVotes({object->id(), votes->connected, votes->apart, votes->occluded}, part, map);
  }
  const auto frames = static_cast<std::uint32_t>(whole.state().supporting_frames);
  AddVotes({whole.id(), frames, 0}, part, map);
}

PartElection::PartElection(const std::vector<TrackedObject*>& objects,
                           const PartDecisions& decisions,
                           double min_connected_share)
    : decisions_(decisions), min_connected_share_(min_connected_share) {
  std::map<ObjectId, std::size_t> sizes;
  for (const TrackedObject* object : objects) {
    sizes.emplace(object->id(), std::max<std::size_t>(1, object->surface().point_count()));
  }
  for (const TrackedObject* object : objects) {
    for (const PartVotes& votes : object->state().parts) {
      const auto other = sizes.find(votes.other);
      if (other == sizes.end()) continue;
      const auto smaller = static_cast<double>(std::min(sizes.at(object->id()), other->second));
      votes_.emplace(
          PairOf(object->id(), votes.other),
          Votes{smaller * votes.connected, smaller * votes.apart, smaller * votes.occluded});
    }
  }
}

PartElection::Pair PartElection::FindPair() const {
  for (const auto& [pair, is_connected] : decisions_) {
    if (is_connected) return pair;
  }
  Pair best;
  double most = min_connected_share_;
  for (const auto& [pair, votes] : votes_) {
    const double share = votes.connected_share();
    if (share <= most || decisions_.contains(pair)) continue;
    most = share;
    best = pair;
  }
  return best;
}

void PartElection::Join(ObjectId part, ObjectId whole) {
  const auto renamed = [&](const Pair& pair) {
    return PairOf(pair.first == part ? whole : pair.first,
                  pair.second == part ? whole : pair.second);
  };
  PartDecisions decisions;
  for (const auto& [pair, is_connected] : decisions_) {
    // What is apart from a part is apart from the whole.
    bool& decision = decisions.try_emplace(renamed(pair), is_connected).first->second;
    decision = decision && is_connected;
  }
  decisions.erase({whole, whole});
  decisions_ = std::move(decisions);
  std::map<Pair, Votes> joined;
  for (const auto& [pair, votes] : votes_) {
    Votes& sum = joined[renamed(pair)];
    sum.connected += votes.connected;
    sum.apart += votes.apart;
    sum.occluded += votes.occluded;
  }
  joined.erase({whole, whole});
  votes_ = std::move(joined);
}

bool PartElection::AreApart(ObjectId a, ObjectId b) const {
  const auto decided = decisions_.find(PairOf(a, b));
  if (decided != decisions_.end()) return !decided->second;
  const auto votes = votes_.find(PairOf(a, b));
  return votes != votes_.end() && votes->second.connected_share() <= min_connected_share_;
}

bool PartElection::IsGapSeen(ObjectId a, ObjectId b) const {
  if (!AreApart(a, b)) return false;
  const auto votes = votes_.find(PairOf(a, b));
  if (decisions_.contains(PairOf(a, b)) || votes == votes_.end()) return true;
  const Votes& counts = votes->second;
  return counts.apart > 0.0 &&
         counts.connected <= min_connected_share_ * (counts.connected + counts.apart);
}

}  // namespace steadymap
