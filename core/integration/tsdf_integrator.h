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

/// The storage location of a leaf: a grid and the origin of the leaf in that grid.
struct LeafPlace {
  TsdfGrid* grid = nullptr;
  LeafOrigin origin;
};

/// Fuses frames into volumes: projects each voxel near the observed surface into the frame and
/// updates its weighted mean distance (Curless and Levoy, 1996). Reuses its memory between frames.
/// One thread at a time.
class TsdfIntegrator {
 public:
  explicit TsdfIntegrator(const MapConfig& config);
  ~TsdfIntegrator();
  TsdfIntegrator(TsdfIntegrator&&) noexcept;
  TsdfIntegrator& operator=(TsdfIntegrator&&) noexcept;

  /// Sets the frame to fuse. The owners of its cells must be set. `cloud` must outlive the
  /// following calls of `Integrate` and `IntegrateWorld` and must not change between them. Together
  /// these calls touch at most `kMaxFusedLeaves` leaves and omit the rest. A frame that passed
  /// `CheckFrameWork` reaches this bound only if many objects share the same space. On oblique
  /// surfaces, the band of one owner is up to `kMaxRayBand` times as deep as the estimate assumes,
  /// which gives at most twice the leaves (1.3 times measured).
  void SetFrame(const SemanticCloud& cloud);

  /// Fuses the cells of the background (owner 0) into `background`, and clears what rays of any
  /// owner pass through: surface in front of a measured depth disappears after about as many
  /// measurements as built it. Appends the changed leaves to `changed_leaves`, each once, sorted.
  void Integrate(Background* background, std::vector<LeafOrigin>* changed_leaves);

  /// Fuses the cells of the background into the leaves returned by `place_of` for each leaf origin
  /// of the world. Appends the changed leaves to `changed_leaves`,
  /// each once, sorted.
  void IntegrateWorld(const std::function<LeafPlace(LeafOrigin)>& place_of,
                      std::vector<LeafOrigin>* changed_leaves);

  /// Fuses the cells of one owner into the grid of an object; clears nothing, since the belief in
  /// an object decides whether it is there. Appends the changed leaves to `changed_leaves`, each
  /// once, sorted. Cost: proportional to these cells and the leaves around them.
  void Integrate(std::uint32_t owner,
                 const Eigen::Isometry3d& T_world_object,
                 TsdfGrid* grid,
                 std::vector<LeafOrigin>* changed_leaves);

 private:
  struct Scratch;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace steadymap
