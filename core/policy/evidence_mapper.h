#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/association/association.h"
#include "core/association/frame_segments.h"
#include "core/association/sample_grid.h"
#include "core/change/min_depth_grid.h"
#include "core/change/surface_looks.h"
#include "core/frame/frame.h"
#include "core/integration/semantic_cloud.h"
#include "core/integration/tsdf_integrator.h"
#include "core/objects/session_identity.h"
#include "core/policy/map_updater.h"
#include "core/policy/segment_assignment.h"
#include "core/policy/stage_observer.h"
#include "core/robot/dynamic_mask.h"
#include "core/robot/localization_monitor.h"
#include "core/robot/pose_filter.h"
#include "core/types/map_config.h"
#include "core/volume/tsdf_sample.h"
#include "core/working/working_map.h"

namespace steadymap {

/// When the session of a robot ends without a message from it.
struct SessionLimits {
  /// Capture times of consecutive frames that are farther apart, seconds, are of two sessions. A
  /// session ends also if the robot finds something gone that it has not seen for so long.
  double max_pause_s = 10.0;
  /// Longest session, seconds: so long a map waits for the decisions on what a robot has seen.
  double max_duration_s = 60.0;

  friend bool operator==(const SessionLimits&, const SessionLimits&) = default;
};

/// The constants of an `EvidenceMapper`.
struct EvidenceMapperParameters {
  SessionLimits sessions;
  LocalizationMonitorParameters guard;
  PoseFilterParameters poses;
  DynamicMaskParameters moving;
  ContinuityParameters continuity;
  LookParameters looks;
  SegmentAssignmentParameters assignment;
  SessionIdentityParameters identity;

  friend bool operator==(const EvidenceMapperParameters&,
                         const EvidenceMapperParameters&) = default;
};

/// Builds the objects of each session apart from the known ones, and decides at the end of the
/// session what they are. In between, every frame is a look at the surface of known objects.
class EvidenceMapper final : public MapUpdater {
 public:
  /// `stages` outlives this object; null: no observer.
  EvidenceMapper(const MapConfig& config,
                 const EvidenceMapperParameters& parameters,
                 StageObserver* stages = nullptr);

  /// Ignores frames of a robot with a wrong pose.
  void Process(const Frame& frame, SemanticCloud* cloud, WorkingMap* map) override;

  bool IsSessionOver(const Frame& next, const WorkingMap& map) const override;

  void EndSession(const SensorName& sensor, WorkingMap* map) override;

 private:
  void BeginSession(const Frame& frame);
  void CorrectPose(const Frame& frame);
  void FindObjects(const SensorName& source);
  void LookAtObjects(const Frame& frame);
  double WeightOf(std::size_t index) const;
  void FindSurfaces();
  void FindSurfaceOf(std::size_t place);
  double LimitAt(float depth_m) const;
  bool IsOnSurface(const SurfaceSample& sample,
                   const DistanceSample& distance,
                   const Eigen::Vector3d& normal) const;
  bool IsStructureInView(const TrackedObject& object) const;
  std::vector<FrameSegment> FindScene() const;
  void RecordGaps(const SegmentAssignment& assignment);
  void FuseSession(const SegmentAssignment& assignment);

  MapConfig config_;
  EvidenceMapperParameters parameters_;
  StageTimer stages_;
  LocalizationMonitor guard_;
  PoseFilter poses_;
  DynamicMask moving_;
  TsdfIntegrator integrator_;

  // The current frame.
  WorkingMap* map_ = nullptr;
  SemanticCloud* cloud_ = nullptr;
  bool has_segments_ = true;  ///< True if the frame has labels or instances.
  SampleGrid samples_;
  MinDepthGrid tiles_;
  std::vector<ObjectInView> in_view_;
  std::vector<SampleOnObject> on_objects_;  ///< Of the session, and structures.
  std::vector<SampleUse> uses_;             ///< By sample.
  std::vector<FrameSegment> segments_;
};

}  // namespace steadymap
