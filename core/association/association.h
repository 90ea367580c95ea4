#pragma once

#include <cstdint>
#include <vector>

#include "core/association/sample_grid.h"
#include "core/integration/tsdf_kernel.h"
#include "core/volume/background.h"
#include "core/working/tracked_object.h"

namespace steadymap {

class FrameClusters;

/// Whom each sample of a frame belongs to.
struct Association {
  /// No known surface explains the sample.
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

  /// Whether an owner is an object in view.
  static constexpr bool IsObject(std::uint32_t owner) {
    return owner != kNone && owner != kBackgroundOwner;
  }

  /// By sample: `kNone`, `kBackgroundOwner`, or the place of the object in the list of objects
  /// in view, plus one.
  std::vector<std::uint32_t> owner;
  /// By sample: signed distance from the owner's surface, metres.
  std::vector<float> distance_m;
  /// By sample: whether it floats in front of a known surface, where nothing was before.
  std::vector<std::uint8_t> is_in_front;
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

/// How far a sample may lie from the surface that explains it, metres: sensor noise and pose error,
/// and no more than a map with this truncation tells apart.
double FitTolerance(float depth_m, double truncation_m);

/// Gives each sample to the object, or the background, on whose surface it lies where it stands
/// (identity first: nothing is moved). Where several qualify: the closest; samples of classes that
/// form objects go to the background only where no object qualifies. `clusters` say what an object
/// may claim at all.
void AssociateSamples(const SampleGrid& samples,
                      const std::vector<ObjectInView>& objects,
                      const Background& background,
                      const VoxelScale& scale,
                      const FrameClusters& clusters,
                      Association* association);

/// Takes its samples from an owner that turned out to stand otherwise than known. They count as new
/// surface in front of it.
void ReleaseSamples(std::uint32_t owner, Association* association);

}  // namespace steadymap
