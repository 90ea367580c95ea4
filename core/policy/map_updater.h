#pragma once

#include <memory>

#include "core/frame/frame.h"
#include "core/integration/semantic_cloud.h"
#include "core/policy/stage_observer.h"
#include "core/types/map_config.h"
#include "core/working/working_map.h"

namespace steadymap {

/// Updates a map by frames with one update policy (`core/README.md`). The result is a function of
/// the map and the frame: all state between frames is in the `WorkingMap`, so that a restart does
/// not change it. One thread at a time.
class MapUpdater {
 public:
  virtual ~MapUpdater() = default;

  /// Integrates `frame` into `map`, between `BeginFrame` and `EndFrame`. `cloud` is the semantic
  /// cloud of the frame. Sets the owners, and may set the weights, of its cells.
  virtual void Process(const Frame& frame, SemanticCloud* cloud, WorkingMap* map) = 0;

  /// True if the session of the robot has ended before its frame `next`.
  virtual bool IsSessionOver(const Frame& /*next*/, const WorkingMap& /*map*/) const {
    return false;
  }

  /// Ends the session of the robot with this sensor: decides what is still open, between
  /// `BeginFrame` and `EndFrame`.
  virtual void EndSession(const SensorName& /*sensor*/, WorkingMap* /*map*/) {}
};

/// Makes the updater of the policy in `config`, which must be valid. `stages` outlives it; null: no
/// observer.
std::unique_ptr<MapUpdater> MakeMapUpdater(const MapConfig& config, StageObserver* stages);

/// True if maps of this policy find objects only by the labels or instances of frames, so that a
/// frame without both adds none.
bool NeedsLabels(UpdatePolicy policy);

/// True if maps of this policy decide at the end of a robot's session what it has seen.
bool HasSessions(UpdatePolicy policy);

}  // namespace steadymap
