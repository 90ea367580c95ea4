#pragma once

#include <cstdint>
#include <vector>

#include "core/frame/frame.h"
#include "core/policy/map_updater.h"
#include "core/policy/segment_fusion.h"
#include "core/registration/registration.h"
#include "core/types/map_config.h"

namespace steadymap {

/// How objects are followed. Defaults: TorWIC at voxels of 5 cm.
struct TrackingParameters {
  /// Wide enough that an object overlaps itself after a jump of the largest size.
  SegmentFusionParameters segments{.overlap = {.depth_tolerance_m = 0.25}};
  /// Searches as far as an object may jump.
  RegistrationParameters registration{.search_distance_m = 0.2};
  /// An object that moves further than this from one frame to the next is lost, metres.
  double max_jump_m = 0.2;
  /// So is one of which half the points that were seen lie further than this from its surface,
  /// voxels. Points of which its volume knows nothing lie further.
  double max_residual_voxels = 3.0;
  /// Objects are registered by at least so many samples.
  std::size_t min_samples = 12;
  /// Frames that must show a new object before it is part of the map.
  std::uint64_t confirming_views = 4;
  /// A tentative object that was not seen for so long is forgotten, seconds.
  double tentative_age_s = 10.0;
  /// A move is told each time that an object has come this far, metres.
  double reported_move_m = 0.1;
};

/// The `tracking` policy (Runz et al., MaskFusion, ISMAR 2018): each object that a frame shows is
/// registered to its segment and takes the pose found; what cannot be registered is dropped. What
/// is simply gone stays in the map for ever.
///
/// `Belief::change_mean_m` of an object is how far it has come since it last rested or a move was
/// told; nothing else of its belief means anything.
class TrackingMapper final : public MapUpdater {
 public:
  TrackingMapper(const MapConfig& config, const TrackingParameters& parameters);

  void Process(const Frame& frame, SemanticCloud* cloud, WorkingMap* map) override;

 private:
  void Follow(std::size_t place);
  void Move(const Registration& registration, TrackedObject* object);
  void SetMoved(double moved_m, TrackedObject* object);
  bool IsLost(const Registration& registration,
              const std::vector<Eigen::Vector3d>& points_world,
              const TrackedObject& object) const;
  void Drop(TrackedObject* object);
  void CountViews();
  void ConfirmAndForget();

  TrackingParameters parameters_;
  SegmentFusion segments_;
  WorkingMap* map_ = nullptr;  ///< Of the frame at hand.
};

}  // namespace steadymap
