#pragma once

#include <cstdint>
#include <vector>

#include "core/association/association.h"
#include "core/objects/reidentification.h"
#include "core/types/map_config.h"
#include "core/working/tracked_object.h"
#include "core/working/working_map.h"

namespace steadymap {

/// When a tentative object becomes part of the map, and as what.
struct ObjectLifecycleParameters {
  ReidentificationParameters recognition;
  /// E[v] of a new object.
  double initial_stationarity = 0.67;
  /// Frames that must agree with it,
  std::uint64_t views = 4;
  /// and how much surface it must show, square metres; what shows less must be seen longer.
  double min_area_m2 = 0.06;
  /// Beside a thing of its class that came lately (`recognition.thing`), so many frames must: until
  /// then it may turn out to be connected.
  std::uint64_t views_beside = 12;
  /// One that was not seen for so long is forgotten, seconds.
  double max_unseen_s = 10.0;
  /// What stands for less long than that is new, seconds.
  double recent_s = 20.0;
  /// Share of an observation that must lie in known free space to be a new thing rather than more
  /// of an old one.
  double free_share = 0.4;
  /// The same for what may be left of an object that went: the space around thin things is free.
  double rest_free_share = 0.8;
  /// Whether new objects are compared with what stood in their place.
  bool recognises_returned = true;
  /// Whether new objects are compared with what they may be left of.
  bool recognises_rests = true;
  /// Whether new objects are compared with what they may be a piece of.
  bool recognises_pieces = true;
};

/// Decides what the tentative objects of a map are: old ones that are back, what is left of one
/// that went, a piece of one that stands, or new ones; and tells it.
class ObjectLifecycle {
 public:
  ObjectLifecycle(const MapConfig& config, const ObjectLifecycleParameters& parameters)
      : config_(config), parameters_(parameters) {}

  /// Decides where enough frames agree, forgets what nobody saw again, and gives objects in view
  /// that came lately what was once known of them.
  void Run(const std::vector<ObjectInView>& in_view, WorkingMap* map);

 private:
  bool Confirm(TrackedObject* object);
  bool TakePlace(TrackedObject* object);
  bool IsBesideRecent(const TrackedObject& object);
  void Enter(EventType type, EventReason reason, ObjectId related, TrackedObject* object);
  void TakeBack(TrackedObject* known, TrackedObject* object);
  void Return(TrackedObject* object, EventReason reason, const Belief& belief);
  void TakeBackParts(const std::vector<ObjectInView>& in_view);
  const TrackedObject* FindWholeOf(const TrackedObject& object);
  bool IsInFreeSpace(const TrackedObject& object) const;
  TrackedObject* FindKnown(const TrackedObject& object);
  std::vector<TrackedObject*> ObjectsAround(const TrackedObject& object, double distance_m);
  bool Stays(const TrackedObject& object) const;

  MapConfig config_;
  ObjectLifecycleParameters parameters_;
  WorkingMap* map_ = nullptr;
};

}  // namespace steadymap
