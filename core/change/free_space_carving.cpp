#include "core/change/free_space_carving.h"

namespace steadymap {
namespace {

// Every so many samples: rays are denser than the cells of free space.
constexpr int kStride = 2;

// Free space ends this far before what was measured: noise and pose error.
constexpr double kMarginM = 0.15;

}  // namespace

void CarveFreeSpace(const SampleGrid& samples,
                    const Eigen::Vector3d& camera_world,
                    Timestamp session_start,
                    WorkingMap* map) {
  for (int row = 0; row < samples.height(); row += kStride) {
    for (int column = 0; column < samples.width(); column += kStride) {
      const SurfaceSample& sample = samples.At(column, row);
      if (!sample.is_valid()) continue;
      const Eigen::Vector3d way = sample.position_world.cast<double>() - camera_world;
      const double length_m = way.norm();
      if (length_m < 2.0 * kMarginM) continue;
      map->MarkFree(camera_world + way * (kMarginM / length_m),
                    camera_world + way * (1.0 - kMarginM / length_m),
                    session_start);
    }
  }
}

}  // namespace steadymap
