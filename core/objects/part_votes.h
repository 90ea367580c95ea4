#pragma once

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "core/map/map_object.h"
#include "core/working/tracked_object.h"
#include "core/working/working_map.h"

/// Objects of a session start as small as frames show them apart. Each frame that shows two of them
/// votes on whether they are parts of one object, so that a single wrong segmentation decides
/// nothing. The newer one of a pair has the votes.
namespace steadymap {

/// How one frame shows two objects of a session.
enum class PartVote {
  kConnected,
  kApart,  ///< It looks through a gap between them, or their instances differ.
  /// Their outlines meet in the image, as those of the rim of a barrel and of its lid: the nearer
  /// one may occlude a connection.
  kOccluded,
};

/// Counts a frame that shows two objects of a session. Frames in which a pair is not connected
/// count only if the objects are near, or were connected in an earlier frame.
void VoteOnParts(PartVote vote, TrackedObject* a, TrackedObject* b, WorkingMap* map);

/// True if frames have voted on two objects.
bool HaveVotes(const TrackedObject& a, const TrackedObject& b);

/// Gives the votes of `whole` to a new object that was a part of it until now. All frames that
/// support `whole` have shown both as one.
void InheritVotes(const TrackedObject& whole, TrackedObject* part, WorkingMap* map);

/// Two objects of a session, the older one first.
using ObjectPair = std::pair<ObjectId, ObjectId>;

inline ObjectPair PairOf(ObjectId a, ObjectId b) { return {std::min(a, b), std::max(a, b)}; }

/// Whether pairs of objects are parts of one object.
using PartDecisions = std::map<ObjectPair, bool>;

/// The votes on all pairs of objects of a session, each by the surface of the smaller one: what is
/// joined to an object tells little about the rest of it. The older one comes first in a key.
class PartElection {
 public:
  using Pair = ObjectPair;

  PartElection() = default;

  /// Counts the votes on pairs of `objects`; those on pairs that are decided do not count. Two are
  /// one object if more than `min_connected_share` of the votes connect them.
  PartElection(const std::vector<TrackedObject*>& objects,
               const PartDecisions& decisions,
               double min_connected_share);

  /// Returns the pair with the largest majority for being one object; ids of zero if there is none.
  Pair FindPair() const;

  /// Adds the votes on `part` to those on `whole`, of which it is a part now.
  void Join(ObjectId part, ObjectId whole);

  /// True if most frames show the two objects apart or occluded.
  bool AreApart(ObjectId a, ObjectId b) const;

  /// True if they are apart by a decision, or by the votes without those of frames in which one may
  /// have occluded a connection.
  bool IsGapSeen(ObjectId a, ObjectId b) const;

 private:
  /// Surface points of the smaller object, added up over the frames.
  struct Votes {
    double connected = 0.0;
    double apart = 0.0;
    double occluded = 0.0;

    double connected_share() const { return connected / (connected + apart + occluded); }
  };

  std::map<Pair, Votes> votes_;
  PartDecisions decisions_;
  double min_connected_share_ = 0.5;
};

}  // namespace steadymap
