#pragma once

#include <vector>

#include "client/bench/simulator/scene/scene.h"
#include "client/bench/simulator/scene/trajectory.h"

namespace steadymap {

/// Motion along a path on the ground.
struct PathMotion {
  double start_m = 0.0;        ///< Position on the path at time 0.
  double speed_m_per_s = 0.0;  ///< Negative: backwards along the path, facing that way.
  double duration_s = 0.0;     ///< Stops after this time.
  double height_m = 0.0;       ///< Height of the origin above the ground.
};

/// Returns the keys of that motion, four per second.
std::vector<MotionKey> MoveAlong(const GroundPath& path, const PathMotion& motion);

/// A standing person 1.75 m tall, origin between the feet.
MeshShape MakePersonShape();

/// A forklift 1.3 m long, 0.8 m wide and 1.9 m tall, origin on the ground, forks ahead (+x).
MeshShape MakeForkliftShape();

/// A toy car 0.24 m long, origin on the ground, +x ahead.
MeshShape MakeToyCarShape();

}  // namespace steadymap
