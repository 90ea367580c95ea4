#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "core/integration/semantic_cloud.h"
#include "core/types/map_config.h"
#include "core/volume/background.h"
#include "core/volume/voxel_leaf.h"

namespace steadymap {

/// Where a leaf is kept: in which grid, and where in it.
struct LeafPlace {
  TsdfGrid* grid = nullptr;
  LeafOrigin origin;
};

/// Fuses frames into a volume: the block-projective update of platform.md. Keeps its scratch memory
/// from frame to frame. One thread at a time.
class TsdfIntegrator {
 public:
  explicit TsdfIntegrator(const MapConfig& config);
  ~TsdfIntegrator();
  TsdfIntegrator(TsdfIntegrator&&) noexcept;
  TsdfIntegrator& operator=(TsdfIntegrator&&) noexcept;

  /// Sets the frame to fuse; its cells must have their owners. It must outlive the calls below and
  /// not change between them. Together these calls touch at most `kMaxFusedLeaves` leaves and leave
  /// out the rest. A frame that passed `CheckFrameWork` reaches that bound only if many objects
  /// share the same space: on slanted surfaces the band of one owner is up to `kMaxRayBand` times
  /// as deep as the estimate takes it to be, which makes at most twice the leaves (1.3 times
  /// measured).
  void SetFrame(const SemanticCloud& cloud);

  /// Fuses the cells that belong to the background (owner 0) into it and appends the leaves that
  /// changed to `changed_leaves`, each once, sorted.
  void Integrate(Background* background, std::vector<LeafOrigin>* changed_leaves);

  /// The same with leaves that are kept where `place_of` says, for each leaf of the world.
  void IntegrateWorld(const std::function<LeafPlace(LeafOrigin)>& place_of,
                      std::vector<LeafOrigin>* changed_leaves);

  /// Fuses the cells of one owner into the grid of an object; likewise. Cost: that of these cells
  /// and of the leaves around them.
  void Integrate(std::uint32_t owner,
                 const Eigen::Isometry3d& T_world_object,
                 TsdfGrid* grid,
                 std::vector<LeafOrigin>* changed_leaves);

 private:
  struct Scratch;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace steadymap
