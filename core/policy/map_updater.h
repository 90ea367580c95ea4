#pragma once

#include <memory>

#include "core/frame/frame.h"
#include "core/integration/semantic_cloud.h"
#include "core/policy/mapper_options.h"
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

  /// Ends the session of the robots: decides what is still open, between `BeginFrame` and
  /// `EndFrame`.
  virtual void EndSession(WorkingMap* /*map*/) {}
};

/// Makes the updater of the policy in `config`, which must be valid.
std::unique_ptr<MapUpdater> MakeMapUpdater(const MapConfig& config, const MapperOptions& options);

/// True if maps of this policy consist of objects. Objects are found by the labels or instances of
/// frames, so a frame without both adds none.
bool KeepsObjects(UpdatePolicy policy);

}  // namespace steadymap
