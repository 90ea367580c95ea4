#pragma once

#include <cstdint>
#include <map>
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
  SessionIdentityParameters identity;
  /// A segment and an object of the session share surface if this share of the smaller one does.
  double min_common_share = 0.2;
  /// A segment of another class is of an object if this share of its samples is on its surface.
  double min_mislabelled_share = 0.6;
  /// Segments with less surface do not start an object, square metres.
  double min_new_area_m2 = 0.002;
};

/// Builds the objects of each session apart from the known ones, and decides at the end of the
/// session what they are. In between, every frame is a look at the surface of known objects.
class EvidenceMapper final : public MapUpdater {
 public:
  EvidenceMapper(const MapConfig& config, const EvidenceMapperParameters& parameters);

  void Process(const Frame& frame, SemanticCloud* cloud, WorkingMap* map) override;

  void EndSession(WorkingMap* map) override;

 private:
  /// A sample on the surface of an object in view.
  struct SampleOnObject {
    std::size_t sample = 0;
    std::size_t place = 0;  ///< In `in_view_`.
  };

  /// The surface that a segment and an object in view have in common.
  struct Claim {
    std::size_t segment = 0;
    std::size_t place = 0;  ///< In `in_view_`.
    double area_m2 = 0.0;
    double share = 0.0;  ///< Of the smaller one of both.
  };

  void LookAtObjects();
  std::vector<Claim> FindClaims() const;
  void FindSurfaces();
  void FindSurfaceOf(std::size_t place);
  double LimitAt(float depth_m) const;
  bool IsOnSurface(const SurfaceSample& sample,
                   const DistanceSample& distance,
                   const Eigen::Vector3d& normal) const;
  bool IsOfObject(const Claim& claim) const;
  void AssignSegments();
  void JoinTentative(std::size_t place, std::size_t into);
  void AddSegmentAsObject(std::size_t index);
  void FuseSession();

  MapConfig config_;
  EvidenceMapperParameters parameters_;
  DynamicMask moving_;
  TsdfIntegrator integrator_;

  // The current frame.
  WorkingMap* map_ = nullptr;
  SemanticCloud* cloud_ = nullptr;
  SampleGrid samples_;
  MinDepthGrid tiles_;
  std::vector<ObjectInView> in_view_;
  std::vector<SampleOnObject> on_objects_;    ///< Of the session.
  std::vector<std::uint8_t> is_mislabelled_;  ///< By sample: its label contradicts the map.
  std::vector<FrameSegment> segments_;
  std::vector<std::size_t> segment_of_;  ///< By sample, plus one; 0: none.
  std::vector<std::size_t> owner_of_;    ///< By segment, the place in `in_view_` plus one; 0: none.
  Association association_;
};

}  // namespace steadymap
