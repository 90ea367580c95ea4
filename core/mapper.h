#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include <absl/status/statusor.h>

#include "core/frame/frame.h"
#include "core/integration/semantic_cloud.h"
#include "core/map/map_snapshot.h"
#include "core/map/robot_state.h"
#include "core/policy/map_updater.h"
#include "core/policy/stage_observer.h"
#include "core/types/identifiers.h"
#include "core/types/map_config.h"
#include "core/working/working_map.h"

namespace steadymap {

/// Builds one map from the entries of its log. The map is a function of the entries alone: the same
/// entries in the same order give the same map, bit for bit, independent of commits and restarts.
///
/// One thread at a time. Published snapshots are never modified.
class Mapper {
 public:
  /// Creates a mapper with an empty map. `stages` outlives it; null: no observer. Errors: those of
  /// `ValidateMapConfig`.
  static absl::StatusOr<std::unique_ptr<Mapper>> Create(const MapConfig& config,
                                                        StageObserver* stages = nullptr);

  /// Continues from a stored map instead of the empty one. Call before the first `Integrate`.
  /// `snapshot.scale` must be the configuration's (asserted).
  void Restore(const MapSnapshot& snapshot);

  /// Integrates the frame with sequence number `sequence`, which must follow `head()` (asserted).
  /// First ends the session of its robot if the frame is of a new one. The frame must have passed
  /// `ValidateFrame` (asserted).
  void Integrate(MapSequence sequence, const Frame& frame);

  /// Ends the session of a robot by the entry with sequence number `sequence`, which must follow
  /// `head()` (asserted). No effect on policies without sessions.
  void EndSession(MapSequence sequence, const SensorName& sensor);

  /// Adds classes to the class table by the entry with sequence number `sequence`, which must
  /// follow `head()` (asserted). The extended table must be valid (asserted).
  void AddClasses(MapSequence sequence, const std::vector<SemanticClass>& classes);

  /// Skips the entry with sequence number `sequence`, which must follow `head()` (asserted).
  void Skip(MapSequence sequence);

  /// Releases the memory that only frames need, a few megabytes. The next frame allocates it again.
  /// Has no other effect.
  void ReleaseFrameMemory();

  /// Returns the newest processed entry, committed or not.
  MapSequence head() const { return MapSequence(map_.revision().value()); }

  /// Returns the memory of the surfaces of objects, bytes, which snapshots do not contain.
  std::size_t surface_bytes() const { return map_.surface_bytes(); }

  /// Returns the state of a robot; null if the map has no frame of it. Valid until the next entry.
  const RobotState* FindRobot(const SensorName& sensor) const { return map_.FindRobot(sensor); }

  /// Returns the number of entries processed since the last commit.
  std::size_t uncommitted_entries() const { return uncommitted_entries_; }

  /// Ends the work since the last commit. Without entries since then the delta is empty.
  MapCommit Commit();

 private:
  Mapper(const MapConfig& config, StageObserver* stages);

  void UseClasses();
  void PrepareForFrames();
  void DecideSession(Revision revision, const SensorName& sensor);

  const std::vector<SemanticClass> created_classes_;  ///< Of the configuration.
  MapConfig config_;                                  ///< Including added classes.
  StageObserver* const observer_;
  StageTimer stages_;
  std::unique_ptr<SemanticCloud> cloud_;  ///< Of the current frame; null after `Rest`.
  std::unique_ptr<MapUpdater> updater_;   ///< Null after `Rest`.
  WorkingMap map_;                        ///< Newer than the last commit.
  std::size_t uncommitted_entries_ = 0;
};

}  // namespace steadymap
