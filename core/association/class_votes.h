#pragma once

#include <map>
#include <vector>

#include "core/map/map_object.h"

namespace steadymap {

/// Adds one frame's vote on an object's class, shared out by the samples of each class, and lets
/// the votes choose. No samples: no vote.
void AddVotes(const std::map<ClassId, std::size_t>& samples_by_class, ObjectState* object);

/// Adds votes to those on an object's class.
void JoinVotes(const std::vector<ClassVote>& votes, ObjectState* object);

}  // namespace steadymap
