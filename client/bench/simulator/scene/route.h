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
  std::string name;  ///< For example `baseline` or `1-5`; valid as a folder name.
  Scene scene;       ///< Ground truth during the sequence.
  Trajectory trajectory;
  double pause_s = 60.0;  ///< Between the end of the previous sequence and the start of this one.
};

/// Sequences that one robot drives one after the other, all in one world frame. Objects keep their
/// ids across sequences (see `CompareScenes`).
struct Route {
  std::string name;
  PinholeCamera camera;
  bool has_instances = false;            ///< Frames have instance labels by default.
  std::vector<RouteSequence> sequences;  ///< At least one.
};

}  // namespace steadymap
