#pragma once

#include "core/map/robot_state.h"
#include "core/objects/session_parameters.h"
#include "core/objects/shape_match.h"
#include "core/types/map_config.h"
#include "core/types/timestamp.h"
#include "core/working/working_map.h"

namespace steadymap {

/// Writes what was decided on the objects of a session into a map: their states and beliefs, and
/// one event per change. All arguments must outlive it.
class SessionOutcomes {
 public:
  SessionOutcomes(const MapConfig& config,
                  const SessionIdentityParameters& parameters,
                  const SensorName& source,
                  WorkingMap* map)
      : config_(config), parameters_(parameters), source_(source), map_(map) {}

  /// Adds an object of the session to the map.
  void Create(TrackedObject* object);

  /// Makes one object of a known one, which may be archived, and one of the session in its place;
  /// deletes `seen`.
  void Confirm(TrackedObject* seen, TrackedObject* known);

  /// Keeps that a structure, of which a session fuses only what is not known, was seen again.
  void ConfirmStructure(TrackedObject* structure);

  /// Makes one object of both ends of a move, by the match of their shapes. It keeps the identity
  /// and the history of the first one; deletes `after`.
  void Join(const ShapeMatch& match, TrackedObject* before, TrackedObject* after);

  /// Archives a known object that is gone. `part_of`: the object of which it was a part; 0: none.
  void Remove(TrackedObject* known, ObjectId part_of);

  /// Takes in that the session found a known object gone. True if another sensor insists that it
  /// stands.
  bool IsContradicted(TrackedObject* known);

  /// Keeps an object that is gone for the session alone. The contradiction is told once.
  void KeepContradicted(TrackedObject* known);

  /// Keeps only the sums of the evidence of the session for an object.
  void Settle(TrackedObject* object);

 private:
  Timestamp LastLookAt(const TrackedObject& known) const;
  void UpdateBeliefOf(double change_m, TrackedObject* object);

  const MapConfig& config_;
  const SessionIdentityParameters& parameters_;
  const SensorName& source_;
  WorkingMap* map_;
};

}  // namespace steadymap
