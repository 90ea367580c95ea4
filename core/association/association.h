#pragma once

#include <cstdint>
#include <vector>

#include "core/association/sample_grid.h"
#include "core/integration/tsdf_kernel.h"
#include "core/working/tracked_object.h"

namespace steadymap {

/// Whom each sample of a frame belongs to.
struct Association {
  /// Nobody owns the sample.
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

  /// Whether an owner is an object in view.
  static constexpr bool IsObject(std::uint32_t owner) {
    return owner != kNone && owner != kBackgroundOwner;
  }

  /// By sample: `kNone`, `kBackgroundOwner`, or the place of the object in the list of objects
  /// in view, plus one.
  std::vector<std::uint32_t> owner;
};

/// An object that a frame may see, and where in the grid of samples.
struct ObjectInView {
  TrackedObject* object = nullptr;
  int first_column = 0;
  int end_column = 0;
  int first_row = 0;
  int end_row = 0;
};

/// Around all that lies within `max_range_m` of the camera, world frame: outside of it, no object
/// is in view.
Box ReachOfView(const SemanticCloud& cloud, double max_range_m);

/// The objects that lie at least partly in the camera's view and within `max_range_m`, in the order
/// given; archived ones left out.
std::vector<ObjectInView> FindObjectsInView(const std::vector<TrackedObject*>& objects,
                                            const SemanticCloud& cloud,
                                            const SampleGrid& samples,
                                            double max_range_m);

}  // namespace steadymap
