#include "core/policy/map_updater.h"

#include "core/integration/tsdf_integrator.h"
#include "core/policy/configured_parameters.h"
#include "core/policy/evidence_mapper.h"
#include "core/policy/paper_mapper.h"
#include "core/policy/submap_change.h"
#include "core/policy/tracking.h"
#include "core/policy/voxel_change.h"

namespace steadymap {
namespace {

/// The `static` policy: every frame is fused, nothing is ever removed.
class StaticUpdater final : public MapUpdater {
 public:
  explicit StaticUpdater(const MapConfig& config) : integrator_(config) {}

  void Process(const Frame& /*frame*/, SemanticCloud* cloud, WorkingMap* map) override {
    integrator_.SetFrame(*cloud);
    map->FuseBackground(&integrator_);
  }

 private:
  TsdfIntegrator integrator_;
};

}  // namespace

std::unique_ptr<MapUpdater> MakeMapUpdater(const MapConfig& config, StageObserver* stages) {
  switch (config.policy) {
    case UpdatePolicy::kStatic:
      return std::make_unique<StaticUpdater>(config);
    case UpdatePolicy::kVoxelChange:
      return std::make_unique<VoxelChangeMapper>(config, VoxelChangeParametersOf(config));
    case UpdatePolicy::kSubmapChange:
      return std::make_unique<SubmapMapper>(config, SubmapChangeParametersOf(config));
    case UpdatePolicy::kTracking:
      return std::make_unique<TrackingMapper>(config, TrackingParametersOf(config));
    case UpdatePolicy::kPocdPaper:
      return std::make_unique<PaperMapper>(config, PaperParametersOf(config));
    case UpdatePolicy::kPocd:
      return std::make_unique<EvidenceMapper>(config, EvidenceParametersOf(config), stages);
  }
  return nullptr;
}

bool NeedsLabels(UpdatePolicy policy) {
  return policy == UpdatePolicy::kSubmapChange || policy == UpdatePolicy::kTracking ||
         policy == UpdatePolicy::kPocdPaper;
}

bool HasSessions(UpdatePolicy policy) { return policy == UpdatePolicy::kPocd; }

}  // namespace steadymap
