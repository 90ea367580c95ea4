#pragma once

#include <cstdint>
#include <vector>

#include "core/change/changed_voxels.h"
#include "core/change/view_free_space.h"
#include "core/frame/frame.h"
#include "core/integration/tsdf_integrator.h"
#include "core/policy/map_updater.h"
#include "core/policy/session_volume.h"
#include "core/types/map_config.h"
#include "core/volume/leaf_set.h"

namespace steadymap {

/// How layers are compared.
struct VoxelChangeParameters {
  ChangedVoxelParameters change;
  /// Layers are compared every so many frames where the frame looks, >= 1, and everywhere when the
  /// visit ends. Less often costs latency, more often time.
  std::uint64_t frames_per_comparison = 5;
  /// A visit ends when no frame comes for so long, seconds of capture time.
  double visit_gap_s = 30.0;
  /// Space up to this depth is looked through, metres.
  double max_depth_m = 5.0;
};

/// The `voxel_change` policy (Fehr et al., ICRA 2017): what a visit sees is fused into a
/// layer of its own, and goes over into the map where the map knows nothing, or knew it less well,
/// or where enough connected voxels have changed. There are no objects: each change is an
/// UPDATED event of the background (object 0, class 0) with the reason seen_through where something
/// was removed, new_surface where it was added, displaced where it was replaced.
class VoxelChangeMapper final : public MapUpdater {
 public:
  VoxelChangeMapper(const MapConfig& config, const VoxelChangeParameters& parameters);

  void Process(const Frame& frame, SemanticCloud* cloud, WorkingMap* map) override;

 private:
  const std::vector<LeafOrigin>& LeavesInView(const ViewFreeSpace& view);
  void ClearLeaf(const ViewFreeSpace& view, LeafOrigin origin, SessionVolume* fresh);
  void TakeOver(const std::vector<LeafOrigin>& origins, const SessionVolume& fresh);
  bool IsKnownBetter(const LeafView& known, const LeafView& fresh, std::size_t offset) const;
  void TakeOverLeaf(LeafOrigin origin, const LeafView& fresh, const LeafMask& changed);
  void Report(const VoxelChange& change);

  VoxelChangeParameters parameters_;
  TsdfIntegrator integrator_;
  MinDepthGrid tiles_;
  LeafSet leaves_in_view_;
  WorkingMap* map_ = nullptr;  ///< Of the frame at hand.
};

}  // namespace steadymap
