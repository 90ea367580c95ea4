#pragma once

#include <memory>

#include "core/frame/frame.h"
#include "core/integration/semantic_cloud.h"
#include "core/policy/mapper_options.h"
#include "core/types/map_config.h"
#include "core/working/working_map.h"

namespace steadymap {

/// Takes frames into a map as one update policy wants it (pocd.md section 7). A function of the map
/// and the frame: whatever lasts stands in the `WorkingMap`, so that a map goes on after a restart
/// as if it had never stopped. One thread at a time.
class MapUpdater {
 public:
  virtual ~MapUpdater() = default;

  /// Takes in `frame`, between `BeginFrame` and `EndFrame` of `map`. `cloud` was just computed from
  /// it; its cells may be given to owners.
  virtual void Process(const Frame& frame, SemanticCloud* cloud, WorkingMap* map) = 0;
};

/// The updater of the configuration's policy. The configuration must be valid.
std::unique_ptr<MapUpdater> MakeMapUpdater(const MapConfig& config, const MapperOptions& options);

/// Whether maps of this policy consist of objects, which are found by the labels and instances of
/// frames: a frame that has neither shows them none.
bool KeepsObjects(UpdatePolicy policy);

}  // namespace steadymap
