#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "client/bench/simulator/scene/scene.h"
#include "client/bench/simulator/scene/trajectory.h"
#include "core/geometry/geometry.h"

namespace steadymap {

/// One drive through one configuration of the world.
struct RouteSequence {
  std::string name;  ///< Such as `baseline` or `1-5`; fit for a folder name.
  Scene scene;       ///< The truth during the sequence.
  Trajectory trajectory;
};

/// Sequences that one robot drives one after the other, all in one world frame. Objects keep their
/// ids from sequence to sequence (see `CompareScenes`).
struct Route {
  std::string name;
  PinholeCamera camera;
  bool has_instances = false;  ///< Whether frames carry instance labels unless told otherwise.
  std::vector<RouteSequence> sequences;  ///< At least one.
};

}  // namespace steadymap
