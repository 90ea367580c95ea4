#pragma once

#include <cstdint>
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
#include "core/robot/dynamic_mask.h"
#include "core/types/map_config.h"
#include "core/volume/tsdf_sample.h"
#include "core/working/working_map.h"

namespace steadymap {

/// The constants of an `EvidenceMapper`.
struct EvidenceMapperParameters {
  DynamicMaskParameters moving;
  ContinuityParameters continuity;
  LookParameters looks;
  SegmentAssignmentParameters assignment;
  SessionIdentityParameters identity;
};

/// Builds the objects of each session apart from the known ones, and decides at the end of the
/// session what they are. In between, every frame is a look at the surface of known objects.
class EvidenceMapper final : public MapUpdater {
 public:
  EvidenceMapper(const MapConfig& config, const EvidenceMapperParameters& parameters);

  void Process(const Frame& frame, SemanticCloud* cloud, WorkingMap* map) override;

  void EndSession(WorkingMap* map) override;

 private:
  void LookAtObjects();
  void FindSurfaces();
  void FindSurfaceOf(std::size_t place);
  double LimitAt(float depth_m) const;
  bool IsOnSurface(const SurfaceSample& sample,
                   const DistanceSample& distance,
                   const Eigen::Vector3d& normal) const;
  std::vector<FrameSegment> FindScene() const;
  void FuseSession(const SegmentAssignment& assignment);

  MapConfig config_;
  EvidenceMapperParameters parameters_;
  DynamicMask moving_;
  TsdfIntegrator integrator_;

  // The current frame.
  WorkingMap* map_ = nullptr;
  SemanticCloud* cloud_ = nullptr;
  bool has_labels_ = true;  ///< Or instances.
  SampleGrid samples_;
  MinDepthGrid tiles_;
  std::vector<ObjectInView> in_view_;
  std::vector<SampleOnObject> on_objects_;  ///< Of the session.
  std::vector<SampleUse> uses_;             ///< By sample.
  std::vector<FrameSegment> segments_;
};

}  // namespace steadymap
